#!/bin/sh
# Installs what building and testing the detector program take: Debian 12, Ubuntu 22.04 and newer.
#   drpai/install-tools.sh            compiler, CMake, OpenCV (about 300 MB)
#   drpai/install-tools.sh --tests    and what its tests and checks take
# Does nothing when all of it is there. Uses sudo if the user is not root.
set -eu
packages='g++ cmake ninja-build libopencv-dev'
case ${1:-} in
  '') ;;
  --tests) packages="$packages doctest-dev clang-tidy" ;;
  *)
    sed -n '2,5s/^# \{0,1\}//p' "$0"
    [ "$1" = -h ] || [ "$1" = --help ] || exit 2
    exit 0
    ;;
esac

missing=
for package in $packages; do
  dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing="$missing $package"
done
if [ -z "$missing" ]; then
  echo "all there: $packages"
  exit 0
fi
if ! command -v apt-get >/dev/null; then
  echo "no apt-get here; install by hand:$missing" >&2
  exit 2
fi
sudo=
if [ "$(id -u)" != 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "not root and no sudo; as root: apt-get install --no-install-recommends$missing" >&2
    exit 2
  fi
  sudo=sudo
fi
# The list of packages may be old or absent, as in a fresh container. $missing is words.
# shellcheck disable=SC2086
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing || {
  $sudo apt-get update -q
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing
}

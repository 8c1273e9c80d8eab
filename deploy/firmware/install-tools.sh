#!/bin/sh
# Installs what building for the ATmega2560 and running the image under simavr take: Debian 12, Ubuntu 22.04 and newer.
#   deploy/firmware/install-tools.sh            compiler, Arduino core, simavr (about 120 MB)
#   deploy/firmware/install-tools.sh --flash    and avrdude, to flash a board
#   deploy/firmware/install-tools.sh --check    install nothing; fail and say what is missing
# Does nothing when all of it is there. Uses sudo if the user is not root.
set -eu
check=false
packages='make gcc-avr avr-libc binutils-avr arduino-core-avr libsimavr-dev libelf-dev'
case ${1:-} in
  '') ;;
  --flash) packages="$packages avrdude" ;;
  --check) check=true ;;
  *)
    sed -n '2,6s/^# \{0,1\}//p' "$0"
    [ "$1" = -h ] || [ "$1" = --help ] || exit 2
    exit 0
    ;;
esac

missing=
for package in $packages; do
  # Where there is no dpkg, everything is missing.
  dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing="$missing $package"
done
if [ -z "$missing" ]; then
  echo "all there: $packages"
  exit 0
fi
if $check; then
  echo "missing:$missing" >&2
  exit 1
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
  # Nobody is there to type a password.
  if ! [ -t 0 ]; then sudo='sudo -n'; fi
fi
# The list of packages may be old or absent, as in a fresh container. $missing and $sudo are words.
# shellcheck disable=SC2086
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing || {
  # shellcheck disable=SC2086
  $sudo apt-get update -q
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing
}

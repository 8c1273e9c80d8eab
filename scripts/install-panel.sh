#!/bin/sh
# Installs what the operator's panel takes: GTK 3, PyGObject and NumPy of the distribution. Debian 12, Ubuntu 22.04 and newer.
#   scripts/install-panel.sh            the panel itself (about 80 MB)
#   scripts/install-panel.sh --test     and a screen without a screen for its tests: Xvfb, openbox, xdotool
#   scripts/install-panel.sh --if-root  only where that takes no password (any option before or after); else a line of text
# Does nothing when all of it is there. Uses sudo if the user is not root.
set -eu
packages='python3-gi python3-gi-cairo gir1.2-gtk-3.0 python3-numpy python3-yaml fonts-dejavu-core adwaita-icon-theme'
if_root=false
for argument in "$@"; do
  case $argument in
    --test) packages="$packages xvfb openbox xdotool x11-utils" ;;
    --if-root) if_root=true ;;
    *)
      sed -n '2,6s/^# \{0,1\}//p' "$0"
      [ "$argument" = -h ] || [ "$argument" = --help ] || exit 2
      exit 0
      ;;
  esac
done

missing=
for package in $packages; do
  dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing="$missing $package"
done
[ -n "$missing" ] || exit 0
if ! command -v apt-get >/dev/null; then
  echo "no apt-get here; install by hand what corresponds to:$missing" >&2
  $if_root && exit 0
  exit 2
fi
sudo=
if [ "$(id -u)" != 0 ]; then
  if $if_root || ! command -v sudo >/dev/null; then
    echo "the panel's packages are not there; as root: apt-get install --no-install-recommends$missing" >&2
    $if_root && exit 0
    exit 2
  fi
  sudo=sudo
fi
# The list of packages may be old or absent, as in a fresh container. $missing is words.
# shellcheck disable=SC2086
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >/dev/null 2>&1 || {
  $sudo apt-get update -qq
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing
}

#!/bin/sh
# Installs what the operator's panel takes: GTK 3, PyGObject and NumPy of the distribution. Debian 12, Ubuntu 22.04 and newer.
#   scripts/install-panel.sh            the panel itself (about 80 MB)
#   scripts/install-panel.sh --test     and a screen without a screen for its tests: Xvfb, openbox, xdotool
#   scripts/install-panel.sh --if-root  only where that takes no password (any option before or after); else a line of text
# Does nothing when all of it is there. Uses sudo if the user is not root.
set -eu
# shellcheck source=scripts/lib/debian.sh
. "$(dirname "$0")/lib/debian.sh"
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
# shellcheck disable=SC2086
install_packages "$if_root" "the operator's panel" $packages

#!/bin/sh
# Installs what building for the ATmega2560 and running the image under simavr take: Debian 12, Ubuntu 22.04 and newer.
#   deploy/firmware/install-tools.sh            compiler, Arduino core, simavr (about 120 MB)
#   deploy/firmware/install-tools.sh --flash    and avrdude, to flash a board
#   deploy/firmware/install-tools.sh --check    install nothing; fail and say what is missing
# Does nothing when all of it is there. Uses sudo if the user is not root.
set -eu
# shellcheck source=scripts/lib/debian.sh
. "$(dirname "$0")/../../scripts/lib/debian.sh"
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
# shellcheck disable=SC2086
if $check; then
  missing=$(missing_packages $packages)
  [ -z "$missing" ] || { echo "missing:$missing" >&2; exit 1; }
else
  install_packages false 'the firmware' $packages
fi

#!/bin/sh
# Installs a browser without a screen, for the tests of the browser console: Debian's chromium and its driver.
#   scripts/install-browser.sh            uses sudo if the user is not root
#   scripts/install-browser.sh --if-root  only where that takes no password; else, or where it cannot be had, a line of text
# Does nothing when both are there. Ubuntu has chromium as a snap alone, which does not run in a container.
set -eu
# shellcheck source=scripts/lib/debian.sh
. "$(dirname "$0")/lib/debian.sh"
if_root=false
case ${1:-} in
  '') ;;
  --if-root) if_root=true ;;
  *)
    sed -n '2,5s/^# \{0,1\}//p' "$0"
    [ "$1" = -h ] || [ "$1" = --help ] || exit 2
    exit 0
    ;;
esac
if command -v chromium >/dev/null && command -v chromedriver >/dev/null; then exit 0; fi
install_packages "$if_root" "the browser for the console's tests" chromium chromium-driver fonts-dejavu-core

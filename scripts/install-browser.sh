#!/bin/sh
# Installs a browser without a screen, for the tests of the browser console: Debian's chromium and its driver.
#   scripts/install-browser.sh            uses sudo if the user is not root
#   scripts/install-browser.sh --if-root  only where that takes no password; else, or where it cannot be had, a line of text
# Does nothing when both are there. Ubuntu has chromium as a snap alone, which does not run in a container.
set -eu
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

# give_up WHY: the tests that need it say so themselves when they are skipped.
give_up() {
  echo "no browser for the console's tests: $1" >&2
  $if_root && exit 0
  exit 2
}

command -v apt-get >/dev/null || give_up 'no apt-get here'
sudo=
if [ "$(id -u)" != 0 ]; then
  if $if_root || ! command -v sudo >/dev/null; then
    give_up 'as root: apt-get install --no-install-recommends chromium chromium-driver'
  fi
  sudo=sudo
fi
install() {
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium chromium-driver \
    fonts-dejavu-core
}
install >/dev/null 2>&1 || {
  $sudo apt-get update -qq && install
} || give_up 'apt has no chromium with a driver'

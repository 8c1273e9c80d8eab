# shellcheck shell=sh
# Debian's packages, for the scripts that install some: sourced, not run. Debian 12, Ubuntu 22.04 and newer.

# missing_packages PACKAGE...: prints those that are not installed; where there is no dpkg, all of them.
missing_packages() {
  for package in "$@"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || printf ' %s' "$package"
  done
}

# install_packages IF_ROOT WHAT PACKAGE...: installs what is missing, by sudo if the user is not root. IF_ROOT true: only
# where that takes no password; where it cannot be done, a line of text about WHAT instead of exit code 2.
install_packages() {
  if_root=$1 what=$2
  shift 2
  missing=$(missing_packages "$@")
  [ -n "$missing" ] || return 0
  if ! command -v apt-get >/dev/null; then
    give_up "$what: no apt-get here; install by hand what corresponds to:$missing"
    return
  fi
  sudo=
  if [ "$(id -u)" != 0 ]; then
    if $if_root || ! command -v sudo >/dev/null; then
      give_up "$what: as root: apt-get install --no-install-recommends$missing"
      return
    fi
    sudo=sudo
    # Where nobody is there to type a password, none is asked for.
    if ! [ -t 0 ]; then sudo='sudo -n'; fi
  fi
  # The list of packages may be old or absent, as in a fresh container. $missing and $sudo are words.
  # shellcheck disable=SC2086
  apt_get install -q $missing >/dev/null 2>&1 || {
    apt_get update -q
    apt_get install -q $missing
  } || give_up "$what: the packages cannot be had:$missing"
}

apt_get() {
  verb=$1
  shift
  # shellcheck disable=SC2086
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get -y --no-install-recommends "$verb" "$@"
}

give_up() {
  echo "$1" >&2
  $if_root || exit 2
}

#!/usr/bin/env bash
# Makes a robot of a board with Ubuntu and ROS 2's apt source: packages, environment, serial names, service. Repeatable.
#   scripts/setup.sh [--dry-run] [--no-apt] [--no-environment] [--no-system] [--enable]
#     --dry-run          print every command, run none
#     --no-apt           leave out apt and rosdep         --no-environment   leave out .venv/
#     --no-system        leave out what goes to /etc      --enable           start the service now and at every boot
# A desk needs none of this: scripts/start.sh --sim sets itself up. DESTDIR=... installs below another root, for images.
set -euo pipefail
# shellcheck source=scripts/lib/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib/setup.sh"

DISTRO=${ROS_DISTRO:-jazzy}
OWNER=${SUDO_USER:-$(id -un)}
GROUP=$(id -gn "$OWNER")
DEST=${DESTDIR:-}
ROS_PACKAGES=(ros-base robot-state-publisher rplidar-ros tf2-msgs py-trees-ros-interfaces rosbag2-storage-mcap)
SYSTEM_PACKAGES=(python3-venv python3-dev python3-rosdep g++ rsync logrotate)
PANEL_PACKAGES=(python3-gi python3-gi-cairo gir1.2-gtk-3.0 python3-numpy python3-yaml fonts-dejavu-core adwaita-icon-theme)
OWN_GROUPS=(dialout video)

dry=false apt=true environment=true system=true enable=false
for argument in "$@"; do
  case $argument in
    --dry-run) dry=true ;;
    --no-apt) apt=false ;;
    --no-environment) environment=false ;;
    --no-system) system=false ;;
    --enable) enable=true ;;
    -h | --help)
      sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *)
      echo "[setup] $argument: no such option; see --help" >&2
      exit 2
      ;;
  esac
done

changed=0

step() { echo "[setup] $*"; }
fail() {
  echo "[setup] FAILED: $*" >&2
  exit 1
}

# run COMMAND...: prints it, and runs it unless this is a dry run.
run() {
  changed=1
  printf '+'
  printf ' %q' "$@"
  printf '\n'
  if $dry; then return; fi
  "$@"
}

as_root() {
  if ((EUID == 0)); then run "$@"; else run sudo "$@"; fi
}

is_installed() { [[ $(dpkg-query -W -f='${db:Status-Abbrev}' "$1" 2>/dev/null) == ii* ]]; }

install_packages() {
  local wanted=("${SYSTEM_PACKAGES[@]}" "${PANEL_PACKAGES[@]}" "${ROS_PACKAGES[@]/#/ros-$DISTRO-}") missing=() package
  for package in "${wanted[@]}"; do is_installed "$package" || missing+=("$package"); done
  if ((${#missing[@]} == 0)); then return; fi
  as_root apt-get update
  # Looked up before anything is installed; a dry run has not fetched the lists.
  if ! $dry && ! apt-cache show "ros-$DISTRO-ros-base" >/dev/null 2>&1; then
    fail "apt knows no ros-$DISTRO-ros-base. Add ROS 2's apt source first: https://docs.ros.org/en/$DISTRO/Installation.html"
  fi
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "${missing[@]}"
}

install_ros_dependencies() {
  [[ -f $DEST/etc/ros/rosdep/sources.list.d/20-default.list ]] || as_root rosdep init
  if ! $dry && rosdep check --from-paths "$ROOT" --ignore-src --rosdistro "$DISTRO" >/dev/null 2>&1; then
    return
  fi
  run rosdep update --rosdistro "$DISTRO"
  run rosdep install --from-paths "$ROOT" --ignore-src --rosdistro "$DISTRO" --default-yes
}

make_environment() {
  if $dry; then
    run "$ROOT/scripts/setup_environment.py"
  else
    set_up
  fi
}

join_groups() {
  local group
  for group in "${OWN_GROUPS[@]}"; do
    [[ " $(id -nG "$OWNER") " == *" $group "* ]] || as_root usermod --append --groups "$group" "$OWNER"
  done
}

# place SOURCE TARGET: a file of deploy/ with its placeholders filled in; nothing where it is there already.
placed=0
place() {
  local source=$ROOT/$1 target=$DEST$2 filled
  filled=$(mktemp)
  sed -e "s|@ROOT@|$ROOT|g" -e "s|@USER@|$OWNER|g" -e "s|@GROUP@|$GROUP|g" "$source" >"$filled"
  placed=0
  if ! cmp --silent "$filled" "$target"; then
    placed=1
    if $dry; then
      as_root install -D --mode=644 "$source" "$target"
    else
      as_root install -D --mode=644 "$filled" "$target"
    fi
  fi
  rm -f "$filled"
}

install_system_files() {
  local name units=0
  place deploy/udev/60-target-nav.rules /etc/udev/rules.d/60-target-nav.rules
  if ((placed)) && [[ -z $DEST ]]; then
    as_root udevadm control --reload
    as_root udevadm trigger --subsystem-match=tty
  fi
  place deploy/logrotate/target-nav /etc/logrotate.d/target-nav
  for name in target-nav target-nav-record; do
    place "deploy/systemd/$name.service" "/etc/systemd/system/$name.service"
    ((units += placed)) || true
  done
  if [[ -n $DEST ]]; then return; fi
  if ((units)); then as_root systemctl daemon-reload; fi
  if $enable && ! systemctl is-enabled --quiet target-nav.service 2>/dev/null; then
    as_root systemctl enable --now target-nav.service
  fi
}

if $apt; then
  step "packages of apt"
  install_packages
  step "ROS packages that package.xml names"
  install_ros_dependencies
fi
if $environment; then
  step "environment .venv/"
  make_environment
fi
if $system; then
  step "groups, serial names, log rotation, service"
  join_groups
  install_system_files
fi
if $dry; then
  step "that would be all; nothing was done"
elif ((changed)); then
  step "done. New groups count from the next login"
else
  step "nothing to do"
fi

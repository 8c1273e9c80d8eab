# Sourced by scripts/*.sh: finds a Python and makes the environment. The work is in scripts/setup_environment.py.
# shellcheck shell=bash

ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
export ROOT

# rclpy writes its log below HOME and does not start without one.
if [[ -z ${HOME:-} || ! -w ${HOME:-/} ]]; then
  export HOME=$ROOT/.cache/home
  mkdir -p "$HOME"
fi

# Left by a Python of another environment with ROS wheels, these would send ours to that one's libraries.
if [[ -n ${_ROS_WHEELS_BOOTSTRAP_COMPLETE:-} ]]; then
  unset _ROS_WHEELS_BOOTSTRAP_COMPLETE LD_LIBRARY_PATH
fi

is_suitable() {
  "$1" -c 'import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 13))' >/dev/null 2>&1 </dev/null
}

# The interpreter an existing .venv was made from, so that a second run does not make it anew only because the
# order on the PATH has changed.
python_of_venv() {
  local config=$ROOT/.venv/pyvenv.cfg home version
  [[ -f $config ]] || return 1
  home=$(sed -n 's/^home *= *//p' "$config")
  version=$(sed -nE 's/^version *= *(3\.[0-9]+).*/\1/p' "$config")
  printf '%s\n' "$home/python$version"
}

# A name on the PATH need not run (pyenv leaves shims for versions that are not active), so each candidate is asked.
find_python() {
  local candidate pyenv_root=${PYENV_ROOT:-$HOME/.pyenv}
  if [[ -n ${PYTHON:-} ]]; then
    if is_suitable "$PYTHON"; then printf '%s\n' "$PYTHON"; return; fi
    echo "[setup] FAILED: PYTHON=$PYTHON does not run as Python 3.10 to 3.13." >&2
    return 1
  fi
  for candidate in "$(python_of_venv)" python3 python3.12 python3.11 python3.13 python3.10 \
    "$pyenv_root"/versions/3.1[0-3].*/bin/python3; do
    if [[ -n $candidate ]] && is_suitable "$candidate"; then printf '%s\n' "$candidate"; return; fi
  done
  echo "[setup] FAILED: no Python 3.10 to 3.13 found. Install one, or name it: PYTHON=/path/to/python3.12 $0" >&2
  return 1
}

# An installed ROS 2 that this shell has not sourced yet; its set-up files use unset variables.
source_installed_ros() {
  local setup=/opt/ros/${ROS_DISTRO:-jazzy}/setup.bash
  if [[ -z ${AMENT_PREFIX_PATH:-} && -f $setup ]]; then
    set +u
    # shellcheck disable=SC1090
    source "$setup"
    set -u
  fi
}

# Makes $ROOT/.venv, or returns at once when nothing has changed. Sets BASE_PYTHON.
set_up() {
  source_installed_ros
  BASE_PYTHON=$(find_python) || return 1
  "$BASE_PYTHON" "$ROOT/scripts/setup_environment.py"
}

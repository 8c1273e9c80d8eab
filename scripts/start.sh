#!/usr/bin/env bash
# Sets up what is needed, then runs a mission.
#   scripts/start.sh --sim [ARENA] [--headless] [options of `target-nav run`]    the full stack against the simulator
#   scripts/start.sh [options of `target-nav run`]                               the robot
set -euo pipefail
# shellcheck source=scripts/lib/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib/setup.sh"

arguments=()
simulated=false
while (($#)); do
  case $1 in
    -h | --help)
      sed -n '2,4s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    --sim)
      simulated=true
      arguments+=(--sim)
      # `--sim` alone means the open floor.
      if [[ -n ${2:-} && ${2:-} != -* ]]; then arguments+=("$2"); shift; else arguments+=(open_floor); fi
      ;;
    --sim=*) simulated=true; arguments+=("$1") ;;
    *) arguments+=("$1") ;;
  esac
  shift
done

set_up

if $simulated; then
  # A simulated robot must not be heard by a real one, nor by a second simulation on this machine. 1 to 100: higher
  # domains reach into the ports Linux hands out.
  export ROS_AUTOMATIC_DISCOVERY_RANGE=${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}
  export ROS_DOMAIN_ID=${ROS_DOMAIN_ID:-$((RANDOM % 100 + 1))}
fi
exec "$ROOT/.venv/bin/target-nav" run "${arguments[@]}"

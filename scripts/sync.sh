#!/usr/bin/env bash
# Brings this checkout to the robot and starts its service again.
#   scripts/sync.sh [--dry-run] [--setup] [--no-restart] [USER@]HOST[:FOLDER]
#     --dry-run      print every command, run none      --no-restart   leave the service as it is
#     --setup        also bring the robot's .venv/ up to date (needed after a change of setup.py or the locks)
# FOLDER is target_nav in the home there. What git ignores is neither sent nor deleted there: .venv/, runs/.
set -euo pipefail
ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
SERVICE=target-nav.service

dry=false setup=false restart=true robot=
for argument in "$@"; do
  case $argument in
    --dry-run) dry=true ;;
    --setup) setup=true ;;
    --no-restart) restart=false ;;
    -h | --help)
      sed -n '2,6s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    -*)
      echo "[sync] $argument: no such option; see --help" >&2
      exit 2
      ;;
    *)
      if [[ -n $robot ]]; then echo "[sync] one robot at a time: $robot or $argument" >&2; exit 2; fi
      robot=$argument
      ;;
  esac
done
if [[ -z $robot ]]; then
  echo "[sync] which robot? scripts/sync.sh [USER@]HOST[:FOLDER]" >&2
  exit 2
fi
host=${robot%%:*}
folder=target_nav
if [[ $robot == *:* ]]; then folder=${robot#*:}; fi
if [[ -z $host || -z $folder ]]; then
  echo "[sync] $robot: it must be [USER@]HOST[:FOLDER]" >&2
  exit 2
fi

run() {
  printf '+'
  printf ' %q' "$@"
  printf '\n'
  if $dry; then return; fi
  "$@"
}

# Deletes last: the robot's side reads its own .gitignore, which has to be there by then. What must not be lost on a
# robot is named besides.
run rsync --archive --compress --delete-after --human-readable --info=stats1 --exclude=/.git \
  --filter=':- .gitignore' --filter='protect /.venv/' --filter='protect /runs/' "$ROOT/" "$host:$folder/"
if $setup; then
  run ssh "$host" "cd $(printf %q "$folder") && bash -c 'source scripts/lib/setup.sh && set_up'"
fi
if $restart; then
  # A robot that has no service yet is not an error: scripts/setup.sh makes it one.
  run ssh -t "$host" "if systemctl cat $SERVICE >/dev/null 2>&1; then sudo systemctl restart $SERVICE; else echo 'no $SERVICE there; scripts/setup.sh installs it'; fi"
fi

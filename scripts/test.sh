#!/usr/bin/env bash
# Sets up what is needed, then tests.
#   scripts/test.sh                  style, types, import contracts, all tests, and the fast tests on other Pythons
#   scripts/test.sh [pytest args]    only pytest, with these arguments
set -euo pipefail
# shellcheck source=scripts/lib/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib/setup.sh"

case ${1:-} in
  -h | --help)
    sed -n '2,4s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac

set_up
cd "$ROOT"
bin=$ROOT/.venv/bin
# One ROS domain for this run, so that two runs on one machine do not hear each other.
export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST
ROS_DOMAIN_ID=$((RANDOM % 100 + 1))
export ROS_DOMAIN_ID

if (($#)); then exec "$bin/python" -m pytest "$@"; fi

rows=()
failed=0

# check NAME COMMAND...: runs it, keeps a row for the table.
check() {
  local name=$1 began=$SECONDS outcome=ok
  shift
  echo "== $name"
  "$@" || { outcome=FAILED; failed=1; }
  rows+=("$(printf '%-34s %-7s %4d s' "$name" "$outcome" $((SECONDS - began)))")
}

# The fast tests in an environment of their own; the output is shown only when they fail, so that the one summary
# of pytest on the screen is that of the full run.
# shellcheck disable=SC2329
fast_tests() {
  local minor=$1 python=$2 log=.cache/pytest-py3$1.log
  "$python" scripts/setup_environment.py --light || return 1
  if ".venv-py3$minor/bin/python" -m pytest -q -n 2 -m 'not slow and not ros' -o cache_dir=".cache/pytest-py3$minor" \
    >"$log" 2>&1; then
    tail -n 1 "$log"
  else
    cat "$log"
    return 1
  fi
}

# The panel's tests drive it on a screen of their own; where its packages cannot be had they are skipped with a reason.
check 'packages of the panel' scripts/install-panel.sh --test --if-root
check 'browser for the console' scripts/install-browser.sh --if-root
check 'ruff check' "$bin/ruff" check .
check 'ruff format' "$bin/ruff" format --check .
check 'mypy' "$bin/mypy"
check 'import contracts' "$bin/lint-imports" --no-logo --cache-dir .cache/import-linter
check 'shellcheck' "$bin/shellcheck" -x scripts/*.sh scripts/lib/*.sh deploy/firmware/*.sh drpai/*.sh .ci/run
# Warnings as errors, unit tests, sanitizers, clang-tidy; the program itself is tested behind the camera process below.
if command -v clang-tidy >/dev/null && [[ -d /usr/include/doctest ]]; then
  check 'C++ detector' drpai/check.sh
else
  rows+=("$(printf '%-34s %s' 'C++ detector' 'no tools: drpai/install-tools.sh --tests')")
fi
# The image that is flashed, with its use of flash and RAM; the tests run it under simavr.
if deploy/firmware/install-tools.sh --check; then
  check 'firmware for the ATmega2560' make --no-print-directory -C deploy/firmware avr
else
  rows+=("$(printf '%-34s %s' 'firmware for the ATmega2560' 'no tools: deploy/firmware/install-tools.sh')")
fi

own=$("$bin/python" -c 'import sys; print(sys.version_info.minor)')
mapfile -t pythons < <("$BASE_PYTHON" scripts/setup_environment.py --list-pythons)
for minor in 10 11 12 13; do
  ((minor == own)) && continue
  path=
  for row in "${pythons[@]}"; do [[ $row == "$minor "* ]] && path=${row#* }; done
  if [[ -n $path ]]; then
    check "fast tests, Python 3.$minor" fast_tests "$minor" "$path"
  else
    rows+=("$(printf '%-34s %s' "fast tests, Python 3.$minor" 'not installed here')")
  fi
done

# What sees and draws, with the oldest OpenCV there is support for beside the newest one of the environment. Its wheel
# wants the NumPy of its time; both lie in a folder of their own that comes first on the path.
# shellcheck disable=SC2329
opencv4_tests() {
  local folder=.cache/opencv4
  if [[ ! -d $folder/cv2 ]]; then
    "$bin/uv" pip install --quiet --no-deps --python "$bin/python" --target "$folder" \
      'opencv-contrib-python-headless==4.6.0.66' 'numpy==1.26.4' || return 1
  fi
  PYTHONPATH=$folder "$bin/python" -m pytest -q -o cache_dir=.cache/pytest-opencv4 \
    tests/unit/detectors tests/unit/sim/test_render_look.py tests/unit/sim/test_render_truth.py \
    tests/unit/sim/test_tags.py
}
if ((own <= 12)); then
  check 'detectors and renderer, OpenCV 4.6' opencv4_tests
fi

check "all tests, Python 3.$own" "$bin/python" -m pytest

printf '\n'
printf '  %s\n' "${rows[@]}"
exit "$failed"

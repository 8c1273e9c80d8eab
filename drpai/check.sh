#!/bin/sh
# What the C++ of the detector has to pass: drpai/check.sh [--deep]
#   a build of program and tests with warnings as errors, the unit tests, the same with sanitizers, clang-tidy;
#   --deep also has clang's analyzer walk through it, which takes as long again.
# Needs what drpai/install-tools.sh --tests installs.
set -eu
cd "$(dirname "$0")"
jobs=$(nproc)
generator=
if command -v ninja >/dev/null 2>&1; then generator='-G Ninja'; fi
for preset in tests sanitize; do
  # The optimised tests lie beside the program: what both need is compiled once.
  folder=build
  if [ "$preset" = sanitize ]; then folder=build-sanitize; fi
  # shellcheck disable=SC2086
  cmake --preset "$preset" $generator >/dev/null
  cmake --build "$folder" --parallel "$jobs"
  "$folder/tests/unit_tests" --no-version=true
done
checks=
if [ "${1:-}" = --deep ]; then checks='--checks=clang-analyzer-*'; fi
# The DRP-AI backend is looked at as well: its command stands in the tests' build, with our own headers for the SDK.
# shellcheck disable=SC2086
printf '%s\n' src/*/*.cpp | xargs -P "$jobs" -n 2 clang-tidy -p build --quiet $checks

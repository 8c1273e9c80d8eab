#!/bin/sh
# Builds the firmware for this machine, as the library that target_nav/sim/host_firmware.py loads.
#   deploy/firmware/build-host.sh [OUT]    default: deploy/firmware/build/libtarget_nav_firmware.so
# Needs a C++11 compiler and nothing else: $CXX, or c++, g++, clang++. Does nothing when OUT is newer than the sources.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
out=${1:-$here/build/libtarget_nav_firmware.so}

compiler=${CXX:-}
for name in c++ g++ clang++; do
  [ -n "$compiler" ] && break
  if command -v "$name" >/dev/null 2>&1; then compiler=$name; fi
done
if [ -z "$compiler" ]; then
  echo "no C++ compiler found (\$CXX, c++, g++, clang++); install one: sudo apt install g++" >&2
  exit 2
fi

if [ -e "$out" ] && [ -z "$(find "$here/target_nav_firmware" "$here/host" "$here/build-host.sh" -newer "$out" -type f)" ]; then
  exit 0
fi
mkdir -p "$(dirname "$out")"
fresh=$out.$$
trap 'rm -f "$fresh"' EXIT
# The sketch without what is the Arduino's own: board.cpp and the .ino.
sources=
for source in "$here"/target_nav_firmware/*.cpp "$here"/host/*.cpp; do
  case $source in */board.cpp) ;; *) sources="$sources '$source'" ;; esac
done
eval "set -- $sources"
# Words in $compiler are words, as in CXX='ccache g++'.
# shellcheck disable=SC2086
$compiler -std=c++11 -O2 -Wall -Wextra -Werror -fPIC -shared -fvisibility=hidden -fno-exceptions -fno-rtti \
  -I"$here/target_nav_firmware" "$@" -o "$fresh"
mv "$fresh" "$out"

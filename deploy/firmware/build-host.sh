#!/bin/sh
# Builds the firmware for this machine, as the library that target_nav/sim/host_firmware.py loads.
#   deploy/firmware/build-host.sh [OUT]    default: deploy/firmware/build/libtarget_nav_firmware.so
# Needs a C++11 compiler and nothing else: $CXX, or c++, g++, clang++; exit code 2 where there is none.
# Does nothing when OUT was built from these very sources on this kind of machine.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
out=${1:-$here/build/libtarget_nav_firmware.so}

# Contents, not times: a checkout and an rsync set those as they like.
fingerprint=$(cd "$here" && { uname -sm; cat build-host.sh target_nav_firmware/*.cpp target_nav_firmware/*.h host/*; } | cksum)
if [ -e "$out" ] && [ "$(cat "$out.sources" 2>/dev/null)" = "$fingerprint" ]; then
  exit 0
fi

compiler=${CXX:-}
for name in c++ g++ clang++; do
  [ -n "$compiler" ] && break
  if command -v "$name" >/dev/null 2>&1; then compiler=$name; fi
done
if [ -z "$compiler" ]; then
  echo "no C++ compiler found (\$CXX, c++, g++, clang++); install one: sudo apt install g++" >&2
  exit 2
fi

mkdir -p "$(dirname "$out")"
fresh=$out.$$
trap 'rm -f "$fresh" "$fresh.sources"' EXIT
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
printf '%s\n' "$fingerprint" >"$fresh.sources"
# Nobody may take a new fingerprint for an old library.
rm -f "$out.sources"
mv "$fresh" "$out"
mv "$fresh.sources" "$out.sources"

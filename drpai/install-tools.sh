#!/bin/sh
# Installs what building and testing the detector program take: Debian 12, Ubuntu 22.04 and newer.
#   drpai/install-tools.sh            compiler, CMake, OpenCV (about 300 MB)
#   drpai/install-tools.sh --tests    and what its tests and checks take
# Does nothing when all of it is there. Uses sudo if the user is not root.
set -eu
# shellcheck source=scripts/lib/debian.sh
. "$(dirname "$0")/../scripts/lib/debian.sh"
packages='g++ cmake ninja-build libopencv-dev'
case ${1:-} in
  '') ;;
  --tests) packages="$packages doctest-dev clang-tidy" ;;
  *)
    sed -n '2,5s/^# \{0,1\}//p' "$0"
    [ "$1" = -h ] || [ "$1" = --help ] || exit 2
    exit 0
    ;;
esac
# shellcheck disable=SC2086
install_packages false 'the C++ detector' $packages

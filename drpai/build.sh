#!/bin/sh
# Builds the detector program: drpai/build.sh    ->  drpai/build/app_yolo_cam
# Does nothing when that is newer than its sources. Exit code 3: OpenCV's headers, CMake or a compiler are missing; the
# Python detector takes the program's place then.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
program=$here/build/app_yolo_cam

if [ -x "$program" ] && [ -z "$(find "$here/src" "$here/generated" "$here/CMakeLists.txt" -newer "$program" -type f)" ]; then
  exit 0
fi
for tool in cmake c++; do
  if ! command -v "$tool" >/dev/null 2>&1; then
    echo "$tool is missing; as root: apt-get install cmake g++ libopencv-dev" >&2
    exit 3
  fi
done
# Asked before CMake is, which takes seconds: this runs at every start.
found=${OpenCV_DIR:-}
for config in /usr/lib/cmake/opencv*/OpenCVConfig.cmake /usr/lib/*/cmake/opencv*/OpenCVConfig.cmake \
  /usr/local/lib/cmake/opencv*/OpenCVConfig.cmake /opt/*/lib/cmake/opencv*/OpenCVConfig.cmake; do
  if [ -e "$config" ]; then found=$config; fi
done
if [ -z "$found" ]; then
  echo "OpenCV's headers are missing; as root: apt-get install libopencv-dev (drpai/install-tools.sh)" >&2
  exit 3
fi
generator=
if command -v ninja >/dev/null 2>&1; then generator='-G Ninja'; fi
# shellcheck disable=SC2086
cmake -S "$here" -B "$here/build" $generator
cmake --build "$here/build" --parallel "$(nproc)" --target app_yolo_cam
# The linker may find nothing new to do; the stamp is what the check above looks at.
touch "$program"

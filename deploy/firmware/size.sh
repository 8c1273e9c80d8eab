#!/bin/sh
# Prints how much of the ATmega2560 an image takes. Fails when less than half of the RAM is left for the stack.
#   deploy/firmware/size.sh IMAGE.elf
set -eu
flash_bytes=262144
ram_bytes=8192
avr-size -A "$1" | awk -v flash="$flash_bytes" -v ram="$ram_bytes" '
  $1 == ".text" { code = $2 }
  $1 == ".data" { data = $2 }
  $1 == ".bss" || $1 == ".noinit" { zeroed += $2 }
  END {
    used = data + zeroed
    printf "flash %d of %d bytes (%.1f %%), RAM %d of %d bytes (%.1f %%), %d free\n",
      code + data, flash, 100 * (code + data) / flash, used, ram, 100 * used / ram, ram - used
    if (used * 2 > ram) { print "more than half of the RAM is taken" > "/dev/stderr"; exit 1 }
  }'

// Stands for the kernel header of the DRP-AI driver: the one request this program makes.
#pragma once

#include <stdint.h>

typedef struct drpai_data {
  uint64_t address;
  uint64_t size;
} drpai_data_t;

#define DRPAI_GET_DRPAI_AREA 0xD0

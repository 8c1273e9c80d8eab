/* The firmware as a library for the simulator: C, so that Python's ctypes can call it.
 *
 * Times are monotonic microseconds. One handle is one Arduino; a handle is used by one thread at a time. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#define TNF_ABI 1
#define TNF_API __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tnf tnf;

/* As struct Params of config.h. */
typedef struct {
  int32_t tick_nm;
  int32_t lever_um;
  int32_t top_speed_umps;
  int32_t deadband_umps;
  int32_t watchdog_us;
  int32_t strafes;
} tnf_params;

/* TNF_ABI of the sources this library was built from. */
TNF_API int32_t tnf_abi(void);
/* What is flashed on the reference robot. */
TNF_API void tnf_reference(tnf_params* params);
TNF_API const char* tnf_version(void);

/* NULL if a parameter is outside what the arithmetic is made for. */
TNF_API tnf* tnf_create(const tnf_params* params, uint64_t now_us);
TNF_API void tnf_destroy(tnf* firmware);

/* Bytes from the host. Returns how many bytes wait to be taken; `pwm` is what the motors get now. */
TNF_API int32_t tnf_feed(tnf* firmware, const uint8_t* bytes, size_t count, uint64_t now_us, int16_t pwm[4]);
/* The encoders' counts now; at least every 10 ms. Returns and sets the same. */
TNF_API int32_t tnf_step(tnf* firmware, uint64_t now_us, const int32_t ticks[4], int16_t pwm[4]);
/* What the firmware has sent, up to `capacity` bytes; returns how many. */
TNF_API int32_t tnf_take(tnf* firmware, uint8_t* bytes, int32_t capacity);
/* 0 idle, 1 velocity, 2 move, 3 motor. */
TNF_API int32_t tnf_mode(const tnf* firmware);
/* Whether the motor driver answers; it does after `tnf_create`. */
TNF_API void tnf_set_driver(tnf* firmware, int32_t answers);

#ifdef __cplusplus
}
#endif

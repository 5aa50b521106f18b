/* SPDX-License-Identifier: MIT */
/* fixed - the few operations that every fixed-point module rounds and clamps with.
 *
 * Internal to shared_c: it has inline bodies, so it is not a public header.
 * Rounding  half up (towards plus infinity) everywhere, in these functions and nowhere else:
 *           fixed_round_shift (in C), fixed_mul_q15 and the FIR's fold (in the port)
 */
#ifndef FIXED_H
#define FIXED_H

#include <stdbool.h>
#include <stdint.h>

#include "port_fixed.h"

_Static_assert((-5 >> 1) == -3, "right shift of a negative must be arithmetic");

#define FIXED_COUNTS_MIN (-8388608L) /* -2^23: the converter's lower rail, HX711 p. 4 */
#define FIXED_COUNTS_MAX 8388607L

/* floor((value + 2^(bits-1)) / 2^bits).  1 <= bits <= 30, value <= 2^31 - 1 - 2^(bits-1) */
static inline int32_t fixed_round_shift(int32_t value, uint8_t bits)
{
    return (value + ((int32_t)1 << (bits - 1U))) >> bits;
}

/* value * gain, rounded half up.  gain_q15 <= 32768, so |result| <= |value| */
static inline int32_t fixed_mul_q15(int32_t value, uint16_t gain_q15)
{
    return port_mul_q15(value, gain_q15);
}

/* Count one more event; a counter stops at its maximum rather than lie by wrapping. */
static inline void fixed_count(uint16_t *counter)
{
    if (*counter != UINT16_MAX) { ++*counter; }
}

/* value inside the converter's 24 bits; each clamped value is counted. */
static inline int32_t fixed_clamp_counts(int32_t value, uint16_t *clipped)
{
    if (value > FIXED_COUNTS_MAX) {
        fixed_count(clipped);
        return FIXED_COUNTS_MAX;
    }
    if (value < FIXED_COUNTS_MIN) {
        fixed_count(clipped);
        return FIXED_COUNTS_MIN;
    }
    return value;
}

#endif

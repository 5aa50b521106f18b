/* SPDX-License-Identifier: MIT */
/* fixed - the few operations that every fixed-point module rounds and clamps with.
 *
 * Internal to shared_c: it has inline bodies, so it is not a public header.
 * Rounding  half up (towards plus infinity) everywhere, once a result: in fixed_mul_q15, in the
 *           FIR's fold (port_fir.h) and in mass.c's division, and nowhere else
 */
#ifndef FIXED_H
#define FIXED_H

#include <stdbool.h>
#include <stdint.h>

#include "port_clamp.h"
#include "port_fixed.h"

_Static_assert((-5 >> 1) == -3, "right shift of a negative must be arithmetic");

#define FIXED_COUNTS_MIN (-8388608L) /* -2^23: the converter's lower rail, HX711 p. 4 */
#define FIXED_COUNTS_MAX 8388607L

/* value * gain, rounded half up.  gain_q15 <= 32768, so |result| <= |value| */
static inline int32_t fixed_mul_q15(int32_t value, uint16_t gain_q15)
{
    return port_mul_q15(value, gain_q15);
}

/* Count one more event; a counter stops at its maximum rather than lie by wrapping. */
static inline void fixed_count(uint16_t *counter)
{
    port_count(counter);
}

/* Whether value fits in the converter's 24 bits: its top byte repeats the sign of the one below. */
static inline bool fixed_is_counts(int32_t value)
{
    const uint8_t sign = ((uint8_t)(value >> 16) & 0x80U) != 0U ? 0xFFU : 0U;

    return (uint8_t)(value >> 24) == sign;
}

/* value inside the converter's 24 bits; each clamped value is counted. */
static inline int32_t fixed_clamp_counts(int32_t value, uint16_t *clipped)
{
    return port_clamp_counts(value, clipped);
}

/* counts * 2^7, for counts inside 24 bits. Up by a byte, which still fits in 32 bits, and down by a
 * bit: avr-gcc makes a loop of a shift by seven. */
static inline int32_t fixed_counts_q7(int32_t counts)
{
    return (counts * 256) >> 1;
}

#endif

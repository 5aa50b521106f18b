/* SPDX-License-Identifier: MIT */
/* rate - the converter's true rate, out of the times at which conversions came.
 *
 * Model     mean of the intervals that agree with one another: within 1/8 until it is known, then
 *           within 1/64. The sum of successive intervals is the time between the first and the last
 *           stamp, so that the jitter of the stamps enters twice however many intervals there are.
 *           After 64 the older half fades.
 * Start     16 intervals in agreement. Lost conversions make intervals longer, never shorter: until
 *           then a shorter one than the candidate takes its place.
 * Formats   intervals: us, 6250..200000 (160..5 Hz)    rate: Hz, Q16
 * Bad data  what is beyond that or disagrees is left out; 4 in a row that disagree are a new rate
 * Context   single caller, not from an ISR
 */
#ifndef RATE_H
#define RATE_H

#include <stdbool.h>
#include <stdint.h>

enum { RATE_START_INTERVALS = 16, RATE_MAX_INTERVALS = 64, RATE_REFUSALS = 4 };

typedef struct {
    uint32_t sum_us;     /* of `intervals` intervals in agreement, < 2^24 */
    uint16_t period_8us; /* candidate, later the mean as of the last refresh; 0: none yet */
    uint8_t  intervals;  /* 0..RATE_MAX_INTERVALS - 1 */
    uint8_t  refused;    /* in a row */
} rate_t;

/* Bits of what rate_take answers. */
enum {
    RATE_IS_NEXT = 1, /* the conversions follow one another on the converter's beat: one period
                       * within 1/64, where a real HX711 keeps to 1/10000. While the rate is not
                       * known, all do that an HX711 can give */
    RATE_CHANGED = 2  /* rate_period_8us says another */
};

void rate_init(rate_t *rate);

/* Take the interval between two conversions; *missed is how many were missing between them, 0
 * while the rate is not known. */
uint8_t rate_take(rate_t *rate, uint32_t interval_us, uint8_t *missed);

/* 0 until it is known. */
uint16_t rate_period_8us(const rate_t *rate);
uint32_t rate_hz_q16(const rate_t *rate);

#endif

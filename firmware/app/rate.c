/* SPDX-License-Identifier: MIT */
#include "rate.h"

#include "port_reach.h"

/* No HX711 is faster than 144 Hz or slower than 9; 63 of the longest sum up to less than 2^24. */
#define INTERVAL_MIN_US 6250UL   /* 160 Hz */
#define INTERVAL_MAX_US 200000UL /* 5 Hz */

enum { START_SHIFT = 4, MAX_SHIFT = 6 }; /* a mean of so many intervals */

_Static_assert(RATE_START_INTERVALS == 1 << START_SHIFT && RATE_MAX_INTERVALS == 1 << MAX_SHIFT,
               "a mean is a shift");

void rate_init(rate_t *rate)
{
    *rate = (rate_t){0};
}

static __attribute__((noinline)) void start_over(rate_t *rate, uint32_t interval_us)
{
    rate->period_us = interval_us;
    rate->sum_us    = interval_us;
    rate->intervals = 1;
    rate->refused   = 0;
}

static bool is_known(const rate_t *rate)
{
    return rate->intervals >= RATE_START_INTERVALS;
}

/* Within 1/8 of the mean until the rate is known, then within 1/64. One copy: it is asked twice. */
static bool agrees(const rate_t *rate, uint32_t interval_us)
{
    const uint32_t period_us    = rate->period_us;
    const uint32_t tolerance_us = period_us >> (is_known(rate) ? 6U : 3U);

    return interval_us - (period_us - tolerance_us) <= 2U * tolerance_us; /* modulo 2^32 */
}

static bool is_possible(uint32_t interval_us)
{
    return interval_us - INTERVAL_MIN_US <= INTERVAL_MAX_US - INTERVAL_MIN_US;
}

bool rate_update(rate_t *rate, uint32_t interval_us)
{
    rate = PORT_REACH(rate);

    if (!is_possible(interval_us)) { return false; }
    if (rate->period_us == 0U) {
        start_over(rate, interval_us);
        return false;
    }
    if (!agrees(rate, interval_us)) {
        const bool was_known = is_known(rate);
        const bool shorter   = interval_us < rate->period_us && !was_known;
        rate->refused++;
        if (!shorter && rate->refused < RATE_REFUSALS) { return false; }
        start_over(rate, interval_us);
        return was_known;
    }

    rate->refused = 0;
    rate->sum_us += interval_us;
    rate->intervals++;
    const bool is_full = rate->intervals == RATE_MAX_INTERVALS;
    if (!is_full && rate->intervals != RATE_START_INTERVALS) { return false; }
    rate->period_us = rate->sum_us >> (is_full ? MAX_SHIFT : START_SHIFT);
    if (is_full) {
        rate->sum_us /= 2U;
        rate->intervals = RATE_MAX_INTERVALS / 2;
    }
    return true;
}

__attribute__((noinline)) uint32_t rate_period_us(const rate_t *rate)
{
    return is_known(rate) ? rate->period_us : 0U;
}

/* intervals * 10^6 * 2^16 / sum_us as a long division in three steps, for the dividend has 42 bits
 * and a 64-bit division would be the only one in the image. */
uint32_t rate_hz_q16(const rate_t *rate)
{
    if (!is_known(rate)) { return 0; }

    uint32_t remainder = (uint32_t)rate->intervals * 1000000UL; /* <= 63e6 < 2^26 */
    uint32_t quotient  = 0;

    for (uint8_t step = 0; step < 3U; step++) { /* the first one gives < 2^16: periods >= 16 us */
        quotient  = (quotient << 8) + remainder / rate->sum_us;
        remainder = (remainder % rate->sum_us) << 8; /* < sum_us * 2^8 <= 2^32 */
    }
    return quotient;
}

bool rate_is_next(const rate_t *rate, uint32_t interval_us)
{
    if (!is_known(rate)) { return is_possible(interval_us); }
    return agrees(rate, interval_us);
}

uint8_t rate_missed(const rate_t *rate, uint32_t interval_us)
{
    uint8_t missed = 0;

    if (!is_known(rate)) { return 0; }
    const uint32_t limit_us = rate->period_us + rate->period_us / 2U;
    while (interval_us > limit_us && missed < UINT8_MAX) {
        interval_us -= rate->period_us;
        missed++;
    }
    return missed;
}

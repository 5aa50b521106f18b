/* SPDX-License-Identifier: MIT */
#include "rate.h"

#include "port_reach.h"
#include "port_wide.h"

/* No HX711 is faster than 144 Hz or slower than 9. */
#define INTERVAL_MIN_8US (6250U / 8U)   /* 160 Hz */
#define INTERVAL_MAX_8US (200000U / 8U) /* 5 Hz: 63 of them are less than 2^24 us */

enum { START_SHIFT = 4 + 3, MAX_SHIFT = 6 + 3 }; /* a mean of so many intervals, of 8 us */

_Static_assert(RATE_START_INTERVALS == 1 << (START_SHIFT - 3) &&
                   RATE_MAX_INTERVALS == 1 << (MAX_SHIFT - 3),
               "a mean is a shift");

void rate_init(rate_t *rate)
{
    *rate = (rate_t){0};
}

static bool is_known(const rate_t *rate)
{
    return rate->intervals >= RATE_START_INTERVALS;
}

/* Take in one interval that is possible; true if what rate_period_8us says has changed. */
static bool take(rate_t *rate, uint32_t interval_us, uint16_t interval_8us, bool agrees)
{
    const bool was_known = is_known(rate);
    uint8_t    shift     = START_SHIFT;

    if (!agrees) {
        const bool shorter = interval_8us < rate->period_8us && !was_known;
        rate->refused++;
        if (!shorter && rate->refused < RATE_REFUSALS && rate->period_8us != 0U) { return false; }
        rate->period_8us = interval_8us;
        rate->sum_us     = interval_us;
        rate->intervals  = 1;
        rate->refused    = 0;
        return was_known;
    }

    uint32_t sum_us = rate->sum_us + interval_us;
    rate->refused   = 0;
    rate->intervals++;
    rate->sum_us = sum_us;
    if (rate->intervals == RATE_MAX_INTERVALS) {
        rate->sum_us    = sum_us >> 1;
        rate->intervals = RATE_MAX_INTERVALS / 2;
        shift           = MAX_SHIFT;
    } else if (rate->intervals != RATE_START_INTERVALS) {
        return false;
    }
    rate->period_8us = (uint16_t)(sum_us >> shift);
    return true;
}

uint8_t rate_take(rate_t *rate, uint32_t interval_us, uint8_t *missed)
{
    rate = PORT_REACH(rate);

    const uint16_t period_8us = rate->period_8us;
    const uint32_t whole_8us  = interval_us >> 3;
    uint16_t       left_8us   = whole_8us > UINT16_MAX ? UINT16_MAX : (uint16_t)whole_8us;
    const bool     known      = is_known(rate);
    /* Within 1/8 of the mean until the rate is known, then within 1/64. */
    const uint16_t tolerance_8us = period_8us >> (known ? 6U : 3U);
    const bool     agrees = (uint16_t)(left_8us - period_8us + tolerance_8us) <= 2U * tolerance_8us;
    const bool     possible = (uint16_t)(left_8us - INTERVAL_MIN_8US) <=
                          INTERVAL_MAX_8US - INTERVAL_MIN_8US;
    uint8_t answer = (known ? agrees : possible) ? RATE_IS_NEXT : 0U;

    if (possible && take(rate, interval_us, left_8us, agrees)) { answer |= RATE_CHANGED; }
    *missed = 0U;
    if (known) {
        for (; left_8us > period_8us + period_8us / 2U; left_8us -= period_8us) { ++*missed; }
    }
    return answer;
}

uint16_t rate_period_8us(const rate_t *rate)
{
    return is_known(rate) ? rate->period_8us : 0U;
}

/* intervals / sum_us, by half seconds to 2^7 us, as a share of 2^32: Hz in Q24. */
__attribute__((noinline)) uint32_t rate_hz_q16(const rate_t *rate)
{
    if (!is_known(rate)) { return 0; }
    return port_wide_ratio(rate->intervals * 500000UL, rate->sum_us << 7) >> 8;
}

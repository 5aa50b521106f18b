/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "hx711.h"

#include <math.h>

/* splitmix64 (Steele, Lea, Flood 2014): 64 state bits suffice for noise, and seeds do not
 * need to be well mixed. */
static uint64_t random_bits(uint64_t *state)
{
    uint64_t z = (*state += 0x9E3779B97F4A7C15ULL);

    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
}

double hx711_random_unit(uint64_t *state)
{
    return ((double)(random_bits(state) >> 11) + 0.5) * 0x1p-53; /* never 0, never 1 */
}

double hx711_random_normal(uint64_t *state)
{
    const double radius = sqrt(-2.0 * log(hx711_random_unit(state)));

    return radius * cos(2.0 * M_PI * hx711_random_unit(state)); /* Box and Muller */
}

double hx711_rate_hz(const hx711_t *hx)
{
    return hx->config.rate_hz * (hx->fault.rate_factor > 0.0 ? hx->fault.rate_factor : 1.0);
}

static void plan(hx711_t *hx)
{
    hx711_schedule_t *s = &hx->schedule;

    for (uint32_t i = 0; i < HX711_SCHEDULED; i++) {
        double at = s->grid;
        if (hx->config.jitter_s > 0.0) {
            at += hx->config.jitter_s * hx->hz * hx711_random_normal(&hx->jitter_state);
        }
        s->ticks[i] = (uint64_t)(at > 0.0 ? at : 0.0);
        if (i && s->ticks[i] <= s->ticks[i - 1]) { s->ticks[i] = s->ticks[i - 1] + 1U; }
        s->grid += hx->hz / hx711_rate_hz(hx);
    }
    s->next   = 0;
    s->count  = HX711_SCHEDULED;
    s->valued = false;
}

void hx711_schedule_from(hx711_t *hx, double first_tick)
{
    hx->schedule.grid = first_tick;
    plan(hx);
}

uint64_t hx711_scheduled_tick(const hx711_t *hx)
{
    return hx->schedule.next < hx->schedule.count ? hx->schedule.ticks[hx->schedule.next]
                                                  : UINT64_MAX;
}

double hx711_take_value(hx711_t *hx)
{
    hx711_schedule_t *s     = &hx->schedule;
    double            value = hx->constant_counts;

    if (!hx->constant && hx->source) {
        if (!s->valued) {
            hx->source(hx->ctx, s->ticks + s->next, s->values + s->next, s->count - s->next);
            s->valued = true;
        }
        value = s->values[s->next];
    }
    s->next++;
    if (s->next == s->count) { plan(hx); }
    return value;
}

/* Gain 128 is the unit; the other inputs see the same bridge with less amplification. */
int32_t hx711_quantise(hx711_t *hx, double value)
{
    value *= hx->gain / 128.0;
    if (hx->config.noise_counts > 0.0) {
        value += hx->config.noise_counts * hx711_random_normal(&hx->noise_state);
    }
    if (hx->fault.noise_counts > 0.0) {
        value += hx->fault.noise_counts * hx711_random_normal(&hx->noise_state);
    }
    if (hx->fault.rail) { value = hx->fault.rail > 0 ? 1e9 : -1e9; }
    if (!(value < HX711_COUNTS_MAX)) { return HX711_COUNTS_MAX; } /* so does NaN */
    if (value < HX711_COUNTS_MIN) { return HX711_COUNTS_MIN; }
    return (int32_t)lrint(value);
}

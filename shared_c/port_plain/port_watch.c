/* SPDX-License-Identifier: MIT */
#include "port_watch.h"

enum { LOWEST = -2048, HIGHEST = 2047, LEAP_MAX = 4095 };

static int16_t limited(int32_t value, int32_t low, int32_t high)
{
    if (value < low) { return (int16_t)low; }
    return (int16_t)(value > high ? high : value);
}

static int32_t grains(const scale_t *scale, int32_t counts_q7)
{
    int32_t apart = (int32_t)((uint32_t)counts_q7 - (uint32_t)scale->anchor_q7);

    for (uint8_t bits = scale->grain; bits != 0U; --bits) { apart >>= 1; }
    return apart;
}

static int16_t size_of(int16_t value)
{
    return (int16_t)(value < 0 ? -value : value);
}

bool port_watch(scale_t *scale, int32_t counts_q7, int32_t raw_q7, bool early)
{
    const int32_t there         = grains(scale, raw_q7);
    const int16_t at            = limited(grains(scale, counts_q7), LOWEST, HIGHEST);
    const int16_t raw           = limited(there, LOWEST, HIGHEST);
    const int16_t band          = scale->band;
    const int16_t three_fourths = (int16_t)(band - (band >> 2));
    const int16_t rough         = (int16_t)(scale->rough_q4 >> 4);
    const int16_t wide          = rough > band ? rough : band;
    const int16_t most          = (int16_t)(rough + (rough >> 1) + 4);
    const int16_t leap          = raw == there ? size_of((int16_t)(raw - scale->raw)) : LEAP_MAX;
    const int16_t reach = (int16_t)(band + (rough * 4 > three_fourths ? rough * 4 : three_fourths));
    int16_t       allowed = band;

    scale->raw      = raw;
    scale->rough_q4 = (uint16_t)(scale->rough_q4 + (leap < most ? leap : most) - rough);
    scale->lag_q3   = (int16_t)(scale->lag_q3 - (scale->lag_q3 >> 3) +
                              limited(raw - at, -wide, wide));
    if (at < scale->low) { scale->low = at; }
    if (at > scale->high) { scale->high = at; }

    if (scale->steady) {
        allowed = (int16_t)(band + (band >> 1));
    } else if (early) {
        allowed = (int16_t)(band >> 1);
    }
    const bool behind = (scale->steady || !early) && size_of(scale->lag_q3) > wide * 4;
    if (scale->begun && !behind && scale->high - scale->low <= allowed &&
        raw - scale->low <= reach && scale->high - raw <= reach) {
        return true;
    }
    scale->low  = 0;
    scale->high = 0;
    scale->raw  = (int16_t)(raw - at);
    return false;
}

/* SPDX-License-Identifier: MIT */
#include "checkweigher_tone.h"

#include "port_fixed.h"
#include "port_wide.h"
#include "scale_wide.h"

enum {
    PASSES      = 4,  /* of means of two: 1 4 6 4 1 in all */
    SPREAD_BITS = 12, /* of the smoothed about their mean: 26 squares stay below 2^29 */
    TONE_SHIFT  = 4,  /* 1/g is below 2^4 */
    UNITS_SHIFT = 8   /* a unit in Q8 */
};

/* Moments of the smoothed, about their means: x itself, its second difference v, its first d. */
enum { UU, UV, UD, VD, DD, MOMENTS };

static int32_t product(int16_t a, int16_t b)
{
    return (int32_t)a * b;
}

static uint32_t size_of(int32_t value)
{
    return value < 0 ? 0U - (uint32_t)value : (uint32_t)value;
}

/* a * b / 2^32, rounded half away from 0. */
static int32_t share_of(int32_t a, uint32_t b)
{
    const int32_t share = (int32_t)port_wide_high(size_of(a), b);

    return a < 0 ? -share : share;
}

bool checkweigher_tone_smooth(int16_t off[], uint8_t len)
{
    for (uint8_t at = 0U; at != len; ++at) {
        if (off[at] == CHECKWEIGHER_OFF_MAX) { return false; }
    }
    /* Means of two, four times over; halves go down and up in turn. */
    for (uint8_t pass = 0U; pass != PASSES; ++pass) {
        const int16_t half = (int16_t)(pass & 1U);
        --len;
        for (uint8_t at = 0U; at != len; ++at) { /* sums stay within 2 (2^14 - 1) + 1 */
            off[at] = (int16_t)((int16_t)(off[at] + off[at + 1U] + half) >> 1);
        }
    }
    return true;
}

static int32_t dot(const int16_t a[], const int16_t b[], uint8_t count)
{
    int32_t sum = 0;

    for (; count != 0U; --count) { sum += port_mul_i16(*a++, *b++); }
    return sum;
}

void checkweigher_tone_sum(checkweigher_sums_t *sums, int16_t smooth[], uint8_t len)
{
    const uint8_t count = (uint8_t)(len - 2U);
    int16_t       least = smooth[0], most = smooth[0];
    int32_t       sum   = 0;
    uint8_t       shift = 0U;

    for (uint8_t at = 1U; at != len; ++at) {
        const int16_t z = smooth[at];
        if (z < least) { least = z; }
        if (z > most) { most = z; }
        if (at <= count) { sum += z; }
    }
    const uint32_t over_count = scale_wide_ratio(1U, count);
    for (uint16_t spread = (uint16_t)(most - least); spread >= 1U << SPREAD_BITS; spread >>= 1) {
        ++shift; /* <= 3 */
    }
    /* half a step of the shift goes into the mean, so that each shift rounds */
    const int16_t mean = (int16_t)(share_of(sum, over_count) - (int16_t)((1U << shift) >> 1));
    for (uint8_t at = 0U; at != len; ++at) {
        smooth[at] = (int16_t)((int16_t)(smooth[at] - mean) >> shift); /* |.| <= 2^12 */
    }
    const int16_t *const z = smooth;
    *sums                  = (checkweigher_sums_t){
                         .sum        = sum,
                         .square     = dot(&z[1], &z[1], count), /* each |.| <= 26 * 2^24 < 2^29 */
                         .neighbour  = dot(&z[1], &z[2], count),
                         .across     = dot(&z[0], &z[2], count),
                         .first      = {z[0], z[1]},
                         .last       = {z[count], z[count + 1U]},
                         .least      = least,
                         .most       = most,
                         .over_count = over_count,
                         .count      = count,
                         .shift      = shift,
    };
}

/* All halved together until 16 bits hold them. */
static void moments(const checkweigher_sums_t *sums, int16_t sum_v, int16_t sum_d,
                    int16_t small[MOMENTS])
{
    const int16_t z0 = sums->first[0], z1 = sums->first[1];
    const int16_t y0 = sums->last[0], y1 = sums->last[1];
    int32_t       all[MOMENTS]; /* each |.| < 2^31 */
    uint32_t      any   = 0U;
    uint8_t       shift = 0U;

    all[UU] = sums->square;
    all[UD] = product(y0, y1) - product(z0, z1);
    all[UV] = 2 * (sums->neighbour - sums->square) - all[UD];
    all[VD] = product(sum_v, (int16_t)(y1 - y0 + z1 - z0)) -
              share_of(product(sum_d, sum_v), sums->over_count);
    all[DD] = 2 * (sums->square - sums->across) + product((int16_t)(y1 + y0), (int16_t)(y1 - y0)) -
              product((int16_t)(z1 + z0), (int16_t)(z1 - z0)) -
              share_of(product(sum_d, sum_d), sums->over_count);
    for (uint8_t at = 0U; at != MOMENTS; ++at) { any |= size_of(all[at]); }
    for (; any >= 1UL << 15; any >>= 1) { ++shift; }
    for (uint8_t at = 0U; at != MOMENTS; ++at) { small[at] = (int16_t)(all[at] >> shift); }
}

/* What the tone has put into sum: -(sum of x - weight), by the mean of its equation. */
static int32_t tone_share(const checkweigher_sums_t *sums)
{
    const int16_t rise_z = (int16_t)(sums->first[1] - sums->first[0]);
    const int16_t rise_y = (int16_t)(sums->last[1] - sums->last[0]);
    const int16_t sum_v  = (int16_t)(rise_y - rise_z); /* |.| <= 2^14 */
    const int16_t sum_d  = (int16_t)(rise_y + rise_z + 2 * (sums->last[0] - sums->first[1]));
    int16_t       m[MOMENTS]; /* |.| <= 2^15, uu and dd below it */

    moments(sums, sum_v, sum_d, m);
    const int32_t det = product(m[UU], m[DD]) - product(m[UD], m[UD]);
    const int32_t g   = product(m[VD], m[UD]) - product(m[UV], m[DD]); /* g det */
    const int32_t b   = product(m[UV], m[UD]) - product(m[VD], m[UU]); /* b det */
    if (det < 0 || g <= det >> TONE_SHIFT) { return 0; }
    const int32_t by_fade = share_of((int32_t)((uint32_t)(int32_t)sum_d << 16), size_of(b));
    const int32_t by_tone = share_of((int32_t)((uint32_t)(int32_t)sum_v << 16), (uint32_t)det);
    const int32_t top     = b < 0 ? by_tone - by_fade : by_tone + by_fade; /* |.| < 2^30 */
    if (size_of(top) >= (uint32_t)g) { return 0; }
    const int32_t share = (int32_t)(scale_wide_ratio(size_of(top), (uint32_t)g) >>
                                    (16U - sums->shift));
    return top < 0 ? -share : share; /* |.| < 2^20 */
}

int32_t checkweigher_tone_solve(const checkweigher_sums_t *sums)
{
    const int32_t sum   = sums->sum + tone_share(sums); /* |.| < 2^21 */
    const int32_t found = share_of(sum * (1L << UNITS_SHIFT), sums->over_count);
    const int32_t least = sums->least * (1L << UNITS_SHIFT);
    const int32_t most  = sums->most * (1L << UNITS_SHIFT);

    if (found < least) { return least; }
    return found > most ? most : found;
}

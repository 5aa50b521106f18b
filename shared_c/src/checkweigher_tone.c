/* SPDX-License-Identifier: MIT */
#include "checkweigher_tone.h"

#include "port_fixed.h"
#include "port_rom.h"
#include "port_wide.h"

#include <string.h>

/* Called from several places each; gcc would copy these into them. */
#define COMPACT __attribute__((noinline))

enum {
    PASSES     = 4, /* of means of two: 1 4 6 4 1 in all */
    EDGES      = PASSES + 2,
    LEVEL      = 1 << 14, /* the largest is brought to at least this, */
    LEVEL_DOWN = 3,       /* and all down again, so that 26 products stay below 2^31 */
    TONE_SHIFT = 4,       /* 1/g is below 2^4 */
    HALVES     = 15       /* Q16 of the smoothed to half units, where up is LEVEL_DOWN */
};

/* Over the inner smoothed: moments of x itself, its second difference v and its first d; sums of v
 * and d, Q16; of Cramer's rule the determinant, g times it and -b times it; and what the tone has
 * put into the sum of x, times g times the determinant. */
enum { UV, UU, DD, VD, UD, MOMENTS, V = MOMENTS, D, DET, G, B, TOP };

/* Products of the sums of v and d: what of the moments DD and VD is not about the means. */
static PORT_ROM const uint8_t of_means[][2] = {{D, D}, {V, D}};

/* Each of the last four is a difference of two products. */
static PORT_ROM const uint8_t solution[][4] = {
    {UU, DD, UD, UD}, {VD, UD, UV, DD}, {VD, UU, UV, UD}, {V, DET, D, B}};

/* a * b / 2^32, half up. A negative one counts as 2^32 more, which is taken off again. */
static COMPACT int32_t share_of(int32_t a, int32_t b)
{
    uint32_t share = port_wide_high((uint32_t)a, (uint32_t)b);

    if (a < 0) { share -= (uint32_t)b; }
    if (b < 0) { share -= (uint32_t)a; }
    return (int32_t)share;
}

/* The product of the two that factors names, over 2^32. */
static COMPACT int32_t product(const int32_t sums[], const uint8_t *factors)
{
    return share_of(sums[port_rom_u8(&factors[0])], sums[port_rom_u8(&factors[1])]);
}

static uint8_t inner(const checkweigher_t *checkweigher)
{
    return (uint8_t)(checkweigher->samples - EDGES);
}

/* The inner smoothed's share of their sum. */
static COMPACT int32_t mean_of(const checkweigher_t *checkweigher, int32_t sum)
{
    return share_of(sum, (int32_t)port_wide_ratio(1U, inner(checkweigher)));
}

void checkweigher_tone_smooth(checkweigher_t *checkweigher)
{
    uint8_t len = checkweigher->samples;

    /* Means of two, four times over; halves go down and up in turn. */
    for (uint8_t pass = 0U; pass != PASSES; ++pass) {
        int16_t *z = checkweigher->off;
        --len;
        for (uint8_t left = len; left != 0U; --left, ++z) { /* sums stay within 2^15 - 1 */
            *z = (int16_t)((int16_t)(z[0] + z[1] + (pass & 1)) >> 1);
        }
    }
}

void checkweigher_tone_level(checkweigher_t *checkweigher)
{
    const uint8_t count = inner(checkweigher);
    int16_t      *z     = checkweigher->off;
    int32_t       sum   = 0;
    uint16_t      any   = 1U; /* bits in use */
    uint8_t       up    = 0U;

    for (uint8_t left = count; left != 0U; --left) { sum += *++z; }
    checkweigher->sum  = sum;
    const int16_t mean = (int16_t)mean_of(checkweigher, sum);
    z                  = checkweigher->off;
    for (uint8_t left = (uint8_t)(count + 2U); left != 0U; --left, ++z) {
        *z = (int16_t)(*z - mean); /* |.| < 2^15: sums of z weigh each first mass once */
        any |= (uint16_t)(*z < 0 ? ~*z : *z);
    }
    for (; any < LEVEL; any = (uint16_t)(any << 1)) { ++up; }
    checkweigher->up = up;
    while (z != checkweigher->off) {
        --z;
        *z = (int16_t)((int16_t)((uint16_t)*z << up) >> LEVEL_DOWN); /* |.| <= 2^12 */
    }
}

static COMPACT int32_t *add_product(int32_t *sum, int16_t a, int16_t b)
{
    *sum += port_mul_i16(a, b);
    return sum + 1;
}

void checkweigher_tone_correlate(checkweigher_t *checkweigher)
{
    const int16_t *z     = checkweigher->off;
    int16_t        sum_v = 0, sum_d = 0; /* |.| <= 2^14 */
    int32_t        m[MOMENTS] = {0};

    for (uint8_t left = inner(checkweigher); left != 0U; --left, ++z) {
        const int16_t u = z[1], d = (int16_t)(z[2] - z[0]), v = (int16_t)(z[2] + z[0] - 2 * u);
        int32_t      *sum = add_product(m, u, v); /* each |.| < 2^31 */
        sum               = add_product(sum, u, u);
        sum               = add_product(sum, d, d);
        add_product(sum, d, v);
        sum_v = (int16_t)(sum_v + v);
        sum_d = (int16_t)(sum_d + d);
    }
    add_product(&m[UD], z[0], z[1]); /* all products in between cancel out */
    add_product(&m[UD], (int16_t)-checkweigher->off[0], checkweigher->off[1]);
    memcpy(checkweigher->sums, m, sizeof m);
    checkweigher->sums[V] = sum_v * 65536L;
    checkweigher->sums[D] = sum_d * 65536L;
}

/* What the tone has put into sum, in half units: -(sum of x - weight), by its equation's mean. */
static int32_t tone_share(checkweigher_t *checkweigher)
{
    int32_t *const m = checkweigher->sums;

    for (uint8_t at = 0U; at != 2U; ++at) {
        m[DD + at] -= mean_of(checkweigher, product(m, of_means[at]));
    }
    for (uint8_t at = 0U; at != sizeof solution / sizeof *solution; ++at) {
        m[DET + at] = product(m, solution[at]) - product(m, &solution[at][2]);
    }
    const int32_t  top = m[TOP], g = m[G];
    const uint32_t size = (uint32_t)(top < 0 ? -top : top);
    if (g <= m[DET] >> TONE_SHIFT || (int32_t)size >= g) { return 0; }
    const int32_t share = (int32_t)(port_wide_ratio(size, (uint32_t)g) >>
                                    (HALVES - LEVEL_DOWN + checkweigher->up));
    return top < 0 ? -share : share; /* |.| < 2^20 */
}

COMPACT int32_t checkweigher_tone_solve(checkweigher_t *checkweigher)
{
    const int32_t share = tone_share(checkweigher);

    return mean_of(checkweigher, share + 2 * checkweigher->sum);
}

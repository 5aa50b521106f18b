/* SPDX-License-Identifier: MIT */
/* mahony_euler - the aerospace angles of the attitude, without a division.
 *
 * With half angles c.. and s.. of yaw, pitch and roll:  w - y, z + x = (cos p - sin p) times cosine
 * and sine of (yaw + roll) / 2;  w + y, z - x = (cos p + sin p) times those of (yaw - roll) / 2.
 * Both amplitudes are at least zero, and pitch / 2 + 45 deg is the angle between them: no arcsine,
 * so that nothing is lost near 90 deg.  The norm does not matter. */
#include "mahony_internal.h"
#include "port_hot.h"
#include "port_rom.h"

#define HALF_TURN    UINT16_C(0x8000) /* angles are in 2^-16 of a turn: sums wrap by themselves */
#define QUARTER_TURN UINT16_C(0x4000)
#define PI_Q13       25736
#define LOCK_Q30     UINT32_C(0x20000) /* 1.2e-4: within 0.01 deg of 90 deg of pitch */

/* 2^15 / (i + 1/2) for i = 128..255: first guess of an inverse. */
static const uint8_t inverse_q8[128] PORT_ROM = {
    255, 253, 251, 249, 247, 245, 244, 242, 240, 238, 237, 235, 233, 232, 230, 228, 227, 225, 224,
    222, 221, 219, 218, 216, 215, 213, 212, 211, 209, 208, 207, 205, 204, 203, 202, 200, 199, 198,
    197, 196, 194, 193, 192, 191, 190, 189, 188, 187, 186, 185, 184, 183, 182, 181, 180, 179, 178,
    177, 176, 175, 174, 173, 172, 171, 170, 169, 168, 168, 167, 166, 165, 164, 163, 163, 162, 161,
    160, 159, 159, 158, 157, 156, 156, 155, 154, 153, 153, 152, 151, 151, 150, 149, 149, 148, 147,
    147, 146, 145, 145, 144, 143, 143, 142, 142, 141, 140, 140, 139, 139, 138, 137, 137, 136, 136,
    135, 135, 134, 133, 133, 132, 132, 131, 131, 130, 130, 129, 129, 128,
};

/* atan(i / 64) in 2^-18 of a turn, and sqrt(1 + (i / 64)^2) in Q15, for i = 0..64. */
static const uint16_t angle_turn18[65] PORT_ROM = {
    0,     652,   1303,  1954,  2604,  3253,  3900,  4545,  5188,  5829,  6467,  7101,  7733,
    8361,  8985,  9605,  10221, 10832, 11439, 12040, 12637, 13228, 13814, 14394, 14968, 15537,
    16100, 16656, 17206, 17750, 18288, 18819, 19344, 19862, 20374, 20879, 21378, 21870, 22355,
    22834, 23306, 23771, 24230, 24682, 25128, 25568, 26001, 26427, 26848, 27262, 27670, 28072,
    28467, 28857, 29241, 29619, 29991, 30357, 30718, 31073, 31423, 31767, 32106, 32439, 32768,
};
static const uint16_t length_q15[65] PORT_ROM = {
    32768, 32772, 32784, 32804, 32832, 32868, 32912, 32963, 33023, 33090, 33166, 33248, 33339,
    33437, 33543, 33656, 33776, 33904, 34039, 34182, 34331, 34487, 34650, 34820, 34996, 35179,
    35369, 35565, 35767, 35975, 36189, 36410, 36636, 36868, 37105, 37348, 37596, 37850, 38109,
    38373, 38642, 38915, 39194, 39477, 39765, 40057, 40354, 40655, 40960, 41269, 41582, 41900,
    42221, 42545, 42874, 43206, 43541, 43880, 44222, 44568, 44916, 45268, 45623, 45980, 46341,
};

typedef struct {
    uint16_t turn16;
    int32_t  half_length;
} polar_t;

static uint32_t size_of(int32_t value)
{
    return value < 0 ? 0U - (uint32_t)value : (uint32_t)value;
}

/* Between the table's places: ratio_q16 <= 2^16 - 1 */
static uint16_t between(const uint16_t table[65], uint16_t ratio_q16)
{
    const uint8_t  place = (uint8_t)(ratio_q16 >> 10);
    const uint16_t low   = port_rom_u16(&table[place]);
    const uint16_t high  = port_rom_u16(&table[place + 1U]);
    const uint16_t rest  = (uint16_t)((ratio_q16 & 0x3FFU) << 6);

    return (uint16_t)(low +
                      (uint16_t)((port_mul_u16((uint16_t)(high - low), rest) + UINT32_C(0x8000)) >>
                                 16));
}

/* Angle of (x, y) from x, and length; not both zero, |x|, |y| < 2^31. */
static polar_t polar(int32_t x, int32_t y)
{
    const uint32_t x_size = size_of(x), y_size = size_of(y);
    const bool     steep = y_size > x_size;
    uint32_t       large = steep ? y_size : x_size;
    uint32_t       small = steep ? x_size : y_size;
    uint8_t        shift = 0U;

    for (; (uint8_t)(large >> 24) == 0U && shift < 24U; shift = (uint8_t)(shift + 8U)) {
        large <<= 8;
        small <<= 8;
    }
    for (; (uint8_t)(large >> 24) < 0x80U && shift < 31U; ++shift) {
        large <<= 1;
        small <<= 1;
    }
    const uint16_t large_q16 = (uint16_t)(large >> 16); /* 2^15 <= . < 2^16: the leading bits */
    const uint16_t small_q16 = (uint16_t)(small >> 16);

    /* 2^31 / large by Newton, r (2 - large r), from 8 bits. */
    const uint8_t  guess       = port_rom_u8(&inverse_q8[(uint8_t)((large_q16 >> 8) - 128U)]);
    const uint32_t unity       = port_mul_u16(large_q16, guess); /* near 2^23 */
    const uint16_t two_q15     = (uint16_t)((UINT32_C(0x1000000) - unity) >> 8);
    const uint32_t inverse     = (port_mul_u16(guess, two_q15) * 2U + 128U) >> 8; /* 2^15..2^16 */
    const uint16_t inverse_q15 = inverse > UINT16_MAX ? UINT16_MAX : (uint16_t)inverse;
    const uint32_t ratio       = (port_mul_u16(small_q16, inverse_q15) >> 8) * 2U; /* Q24 */
    const uint16_t ratio_q16   = ratio > UINT32_C(0xFFFFFF) ? UINT16_MAX : (uint16_t)(ratio >> 8);

    uint16_t turn16 = (uint16_t)((uint16_t)(between(angle_turn18, ratio_q16) + 2U) >> 2);
    if (steep) { turn16 = (uint16_t)(QUARTER_TURN - turn16); }
    if (x < 0) { turn16 = (uint16_t)(HALF_TURN - turn16); }
    if (y < 0) { turn16 = (uint16_t)(0U - turn16); }
    uint32_t length = port_mul_u16(large_q16, between(length_q15, ratio_q16)); /* Q31 of half */
    for (; shift >= 8U; shift = (uint8_t)(shift - 8U)) { length >>= 8; }       /* shift >= 1 */
    for (; shift != 0U; --shift) { length >>= 1; }

    return (polar_t){turn16, (int32_t)length};
}

/* To rad, -pi..pi. */
static int16_t rad_q13(uint16_t turn16)
{
    return (int16_t)((port_mul_i16((int16_t)turn16, PI_Q13) * 2 + INT32_C(0x8000)) >> 16);
}

/* Half of yaw plus or minus roll; where it does not exist it is what it was. */
static int32_t half_angle(int32_t x, int32_t y, uint16_t *turn16)
{
    if (size_of(x) < LOCK_Q30 && size_of(y) < LOCK_Q30) { return 0; }
    const polar_t half = polar(x, y);

    *turn16 = half.turn16;
    return half.half_length;
}

void mahony_euler(const mahony_t *mahony, mahony_euler_t *euler)
{
    const int32_t *const q    = mahony->step.quat_wb_q30;
    const int32_t        sum  = half_angle(q[0] - q[2], q[3] + q[1], &euler->half_sum_turn16);
    const int32_t        diff = half_angle(q[0] + q[2], q[3] - q[1], &euler->half_diff_turn16);
    const uint16_t       half = polar(sum, diff).turn16; /* pitch / 2 + 45 deg */

    euler->yaw_q13   = rad_q13((uint16_t)(euler->half_sum_turn16 + euler->half_diff_turn16));
    euler->roll_q13  = rad_q13((uint16_t)(euler->half_sum_turn16 - euler->half_diff_turn16));
    euler->pitch_q13 = rad_q13((uint16_t)(2U * half - QUARTER_TURN));
}

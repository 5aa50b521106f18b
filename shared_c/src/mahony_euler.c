/* SPDX-License-Identifier: MIT */
/* mahony_euler - the aerospace angles of the attitude, without a division.
 *
 * With half angles c.. and s.. of yaw, pitch and roll:  w - y, z + x = (cos p - sin p) times cosine
 * and sine of (yaw + roll) / 2;  w + y, z - x = (cos p + sin p) times those of (yaw - roll) / 2.
 * Both amplitudes are at least zero, and pitch / 2 + 45 deg is the angle between them: no arcsine,
 * so that nothing is lost near 90 deg.  The norm does not matter. */
#include "mahony_internal.h"
#include "port_rom.h"

#define PI_Q16      INT32_C(205887)
#define HALF_PI_Q16 INT32_C(102944)
#define LOCK_Q30    UINT32_C(0x20000) /* 1.2e-4: within 0.01 deg of 90 deg of pitch */

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

/* atan(i / 64), rad in Q16, and sqrt(1 + (i / 64)^2) in Q15, for i = 0..64. */
static const uint16_t angle_q16[65] PORT_ROM = {
    0,     1024,  2047,  3070,  4091,  5110,  6126,  7140,  8150,  9156,  10158, 11155, 12147,
    13133, 14114, 15088, 16055, 17015, 17968, 18913, 19850, 20779, 21699, 22610, 23512, 24406,
    25289, 26163, 27028, 27882, 28727, 29561, 30386, 31200, 32003, 32797, 33580, 34353, 35115,
    35867, 36608, 37340, 38060, 38771, 39472, 40162, 40842, 41512, 42172, 42823, 43464, 44095,
    44716, 45328, 45931, 46525, 47109, 47685, 48251, 48809, 49359, 49899, 50432, 50956, 51472,
};
static const uint16_t length_q15[65] PORT_ROM = {
    32768, 32772, 32784, 32804, 32832, 32868, 32912, 32963, 33023, 33090, 33166, 33248, 33339,
    33437, 33543, 33656, 33776, 33904, 34039, 34182, 34331, 34487, 34650, 34820, 34996, 35179,
    35369, 35565, 35767, 35975, 36189, 36410, 36636, 36868, 37105, 37348, 37596, 37850, 38109,
    38373, 38642, 38915, 39194, 39477, 39765, 40057, 40354, 40655, 40960, 41269, 41582, 41900,
    42221, 42545, 42874, 43206, 43541, 43880, 44222, 44568, 44916, 45268, 45623, 45980, 46341,
};

typedef struct {
    int32_t  angle_q16; /* -pi..pi */
    uint32_t length;    /* in units of the components */
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

/* Angle of (x, y) from x, and length; not both zero, |x|, |y| <= 2^31 - 1. */
static polar_t polar(int32_t x, int32_t y)
{
    const uint32_t x_size = size_of(x), y_size = size_of(y);
    uint32_t       large = x_size, small = y_size;
    uint8_t        shift = 0U;

    if (y_size > x_size) {
        large = y_size;
        small = x_size;
    }
    for (; large >> 23 == 0U && shift < 24U; shift = (uint8_t)(shift + 8U)) {
        large <<= 8;
        small <<= 8;
    }
    for (; large >> 30 == 0U && shift < 31U; ++shift) {
        large <<= 1;
        small <<= 1;
    }
    const uint16_t large_q16 = (uint16_t)(large >> 15); /* 2^15 <= . < 2^16: the leading bits */
    const uint16_t small_q16 = (uint16_t)(small >> 15);

    /* 2^31 / large by Newton, r (2 - large r), from 8 bits. */
    const uint8_t  guess       = port_rom_u8(&inverse_q8[(uint8_t)((large_q16 >> 8) - 128U)]);
    const uint32_t unity       = port_mul_u16(large_q16, guess); /* near 2^23 */
    const uint16_t two_q15     = (uint16_t)((UINT32_C(0x1000000) - unity) >> 8);
    const uint32_t inverse     = (port_mul_u16(guess, two_q15) + 64U) >> 7; /* 2^15..2^16 */
    const uint16_t inverse_q15 = inverse > UINT16_MAX ? UINT16_MAX : (uint16_t)inverse;
    const uint32_t ratio       = port_mul_u16(small_q16, inverse_q15) >> 15;
    const uint16_t ratio_q16   = ratio > UINT16_MAX ? UINT16_MAX : (uint16_t)ratio;

    int32_t angle = between(angle_q16, ratio_q16);
    if (y_size > x_size) { angle = HALF_PI_Q16 - angle; }
    if (x < 0) { angle = PI_Q16 - angle; }
    if (y < 0) { angle = -angle; }
    const uint32_t length = port_mul_u16(large_q16, between(length_q15, ratio_q16));

    return (polar_t){angle, length >> shift};
}

/* rad in Q13, turned into -pi..pi. */
static int16_t wrapped_q13(int32_t angle)
{
    if (angle > PI_Q16) { angle -= 2 * PI_Q16; }
    if (angle < -PI_Q16) { angle += 2 * PI_Q16; }
    return (int16_t)((angle + 4) >> 3);
}

/* Half of yaw plus or minus roll; where it does not exist it is what it was. */
static polar_t half_angle(int32_t x, int32_t y, int16_t *held_q13)
{
    if (size_of(x) < LOCK_Q30 && size_of(y) < LOCK_Q30) {
        return (polar_t){*held_q13 * INT32_C(8), 0U};
    }
    const polar_t half = polar(x, y);

    *held_q13 = wrapped_q13(half.angle_q16);
    return half;
}

void mahony_euler(const mahony_t *mahony, mahony_euler_t *euler)
{
    const int32_t *const q     = mahony->step.quat_wb_q30;
    const polar_t        sum   = half_angle(q[0] - q[2], q[3] + q[1], &euler->half_sum_q13);
    const polar_t        diff  = half_angle(q[0] + q[2], q[3] - q[1], &euler->half_diff_q13);
    const polar_t        pitch = polar((int32_t)(sum.length >> 1), (int32_t)(diff.length >> 1));

    euler->yaw_q13   = wrapped_q13(sum.angle_q16 + diff.angle_q16);
    euler->roll_q13  = wrapped_q13(sum.angle_q16 - diff.angle_q16);
    euler->pitch_q13 = wrapped_q13(2 * pitch.angle_q16 - HALF_PI_Q16);
}

/* SPDX-License-Identifier: MIT */
/* mahony_root - inverse square roots without a division. */
#include "mahony_internal.h"
#include "port_rom.h"

/* 2^7 / sqrt(m) - 2^7 for the middle of m = [i, i + 1) / 256, i = 64..255. */
static const uint8_t root_q7[192] PORT_ROM = {
    127, 125, 123, 121, 119, 118, 116, 114, 113, 111, 109, 108, 106, 105, 103, 102, 100, 99, 97, 96,
    95,  93,  92,  91,  90,  88,  87,  86,  85,  84,  83,  82,  80,  79,  78,  77,  76,  75, 74, 73,
    72,  71,  70,  70,  69,  68,  67,  66,  65,  64,  63,  63,  62,  61,  60,  59,  59,  58, 57, 56,
    56,  55,  54,  53,  53,  52,  51,  51,  50,  49,  49,  48,  47,  47,  46,  45,  45,  44, 44, 43,
    42,  42,  41,  41,  40,  39,  39,  38,  38,  37,  37,  36,  36,  35,  35,  34,  34,  33, 33, 32,
    32,  31,  31,  30,  30,  29,  29,  28,  28,  27,  27,  27,  26,  26,  25,  25,  24,  24, 24, 23,
    23,  22,  22,  22,  21,  21,  20,  20,  20,  19,  19,  18,  18,  18,  17,  17,  17,  16, 16, 16,
    15,  15,  15,  14,  14,  13,  13,  13,  12,  12,  12,  12,  11,  11,  11,  10,  10,  10, 9,  9,
    9,   8,   8,   8,   7,   7,   7,   7,   6,   6,   6,   5,   5,   5,   5,   4,   4,   4,  4,  3,
    3,   3,   2,   2,   2,   2,   1,   1,   1,   1,   0,   0,
};

static uint8_t top_byte(uint32_t value)
{
    return (uint8_t)(value >> 24); /* compared instead of shifting, which takes a loop */
}

mahony_root_t mahony_root(uint32_t value)
{
    uint8_t shift = 0U;

    for (; top_byte(value) == 0U && shift < 12U; shift = (uint8_t)(shift + 4U)) { value <<= 8; }
    for (; top_byte(value) < 64U && shift < 15U; ++shift) { value <<= 2; }
    const uint8_t  index    = (uint8_t)(top_byte(value) - 64U); /* 0..191 for value > 0 */
    const uint16_t first_q7 = (uint16_t)(128U + port_rom_u8(&root_q7[index]));
    /* Newton: y' = y (3 - m y^2) / 2, m y^2 near 1 in Q30. From 5e-3 the error falls below 4e-5. */
    const uint16_t m_q16      = (uint16_t)(value >> 16);
    const uint32_t product    = port_mul_u16(m_q16, (uint16_t)(first_q7 * first_q7));
    const uint16_t factor_q14 = (uint16_t)((UINT32_C(0xC0000000) - product) >> 16);
    const uint32_t inverse    = (port_mul_u16(first_q7, factor_q14) * 2U) >> 8;

    return (mahony_root_t){m_q16, inverse > UINT16_MAX ? UINT16_MAX : (uint16_t)inverse, shift};
}

int16_t mahony_unit_q14(int16_t component, const mahony_root_t *root)
{
    /* c y 2^(shift - 17), see mahony_root_t: (c 2^shift / 2) (y / 2) 2^-15, |c 2^shift| < 2^16 */
    int16_t near = component;

    if (root->shift == 0U) { near = (int16_t)(near >> 1); }
    for (uint8_t left = root->shift; left > 1U; --left) { near = (int16_t)(near * 2); }
    const int32_t product = port_mul_i16(near, (int16_t)(root->inverse_q15 >> 1)); /* < 2^30 */

    return (int16_t)((product * 2 + INT32_C(0x8000)) >> 16);
}

uint16_t mahony_length(const mahony_root_t *root)
{
    const uint32_t product = port_mul_u16(root->m_q16, root->inverse_q15); /* sqrt m in Q31 */
    uint16_t       length  = (uint16_t)(product >> 16);                    /* in Q15, < 2^15 */

    if (root->shift == 0U) { return (uint16_t)(length * 2U); }
    for (uint8_t left = root->shift; left > 1U; --left) { length >>= 1; }
    return length;
}

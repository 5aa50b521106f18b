/* SPDX-License-Identifier: MIT */
#include "scale_wide.h"

#include "port_fixed.h"

scale_wide_t scale_wide_product(uint32_t a, uint32_t b)
{
    const uint16_t a_low = (uint16_t)a, a_high = (uint16_t)(a >> 16);
    const uint16_t b_low = (uint16_t)b, b_high = (uint16_t)(b >> 16);
    const uint32_t low = port_mul_u16(a_low, b_low);
    /* at most (2^16 - 1)^2 + 2^16 - 1 < 2^32, twice over */
    const uint32_t cross = port_mul_u16(a_high, b_low) + (low >> 16);
    const uint32_t other = port_mul_u16(a_low, b_high) + (uint16_t)cross;
    const uint32_t high  = port_mul_u16(a_high, b_high) + (cross >> 16) + (other >> 16);

    return (scale_wide_t){(other << 16) | (uint16_t)low, high};
}

uint32_t scale_wide_ratio(uint32_t a, uint32_t b)
{
    uint32_t quotient = 0U;

    for (uint8_t bit = 0U; bit < 32U; ++bit) {
        a <<= 1; /* a < b <= 2^31 */
        quotient <<= 1;
        if (a >= b) {
            a -= b;
            quotient |= 1U;
        }
    }
    return quotient;
}

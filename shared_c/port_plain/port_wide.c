/* SPDX-License-Identifier: MIT */
#include "port_wide.h"

uint32_t port_wide_high(uint32_t a, uint32_t b)
{
    return (uint32_t)(((uint64_t)a * b + 0x80000000U) >> 32);
}

int32_t port_wide_share(int32_t value, uint32_t share_q32)
{
    if (value < 0) { return -(int32_t)port_wide_high(0U - (uint32_t)value, share_q32); }
    return (int32_t)port_wide_high((uint32_t)value, share_q32);
}

uint32_t port_wide_ratio(uint32_t a, uint32_t b)
{
    uint32_t quotient = 0U;

    for (uint8_t bit = 0U; bit < 32U; ++bit) {
        a <<= 1;
        quotient <<= 1;
        if (a >= b) {
            a -= b;
            quotient |= 1U;
        }
    }
    return quotient;
}

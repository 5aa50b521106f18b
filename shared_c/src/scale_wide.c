/* SPDX-License-Identifier: MIT */
#include "scale_wide.h"

__attribute__((noinline)) uint32_t scale_wide_ratio(uint32_t a, uint32_t b)
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

/* SPDX-License-Identifier: MIT */
/* port_root - contract: shared_c/src/port_root.h */
#include "port_root.h"

uint16_t port_root(uint32_t value)
{
    uint16_t root = 0U;

    for (uint16_t bit = 0x4000U; bit != 0U; bit >>= 1) {
        const uint16_t more = root | bit;

        if ((uint32_t)more * more <= value) { root = more; }
    }
    return root;
}

uint16_t port_ratio_q15(uint16_t part, uint16_t whole)
{
    uint16_t ratio_q15 = 0U;

    for (uint8_t left = 16U; left != 0U; --left) {
        ratio_q15 = (uint16_t)(ratio_q15 * 2U);
        if (part >= whole) {
            part = (uint16_t)(part - whole);
            ratio_q15 |= 1U;
        }
        part = (uint16_t)(part * 2U); /* part < whole < 2^15 */
    }
    return ratio_q15;
}

/* SPDX-License-Identifier: MIT */
#include "port_fir.h"

#include "port_rom.h"

static int32_t sample(const uint8_t at[])
{
    return (int32_t)(at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16);
}

int32_t port_fir_fold(const uint8_t window[], const int16_t half_q15[], uint8_t pairs)
{
    const uint8_t *newest = &window[3 * (2 * pairs - 1)];
    int64_t        sum    = -((int64_t)1 << 38) + (1 << 14);

    for (uint8_t k = 0U; k < pairs; ++k) {
        const int32_t folded = sample(&window[3 * k]) + sample(newest - 3 * k); /* < 2^25 */

        sum += (int64_t)port_rom_i16(&half_q15[k]) * folded;
    }
    return (int32_t)(sum >> 15);
}

/* SPDX-License-Identifier: MIT */
#include "port_fir.h"

#include "port_rom.h"

static int32_t sample(const uint8_t at[])
{
    return (int32_t)(at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16);
}

int32_t port_fir_fold(const uint8_t ring[], const fir_config_t *config, uint8_t oldest)
{
    const uint8_t size  = (uint8_t)(FIR_SAMPLE_BYTES * config->taps);
    const uint8_t pairs = config->taps / 2U;
    uint8_t       older = oldest;
    uint8_t       newer = oldest;
    int64_t       sum   = -((int64_t)1 << 38) + (1 << 14);

    for (uint8_t k = 0U; 2U * k < config->taps; ++k) {
        const int16_t tap    = config->loaded ? config->half_q15[k]
                                              : port_rom_i16(&config->half_q15[k]);
        int32_t       folded = sample(&ring[older]); /* < 2^25 with its mirror image */

        older = (uint8_t)(older + FIR_SAMPLE_BYTES);
        if (older == size) { older = 0U; }
        if (k < pairs) {
            newer = (uint8_t)((newer == 0U ? size : newer) - FIR_SAMPLE_BYTES);
            folded += sample(&ring[newer]);
        }
        sum += (int64_t)tap * folded;
    }
    return (int32_t)(sum >> 15);
}

int32_t port_fir_fold_default(const uint8_t row[], const fir_config_t *config)
{
    return port_fir_fold(row, config, 0U);
}

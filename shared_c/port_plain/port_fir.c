/* SPDX-License-Identifier: MIT */
#include "port_fir.h"

#include "fixed.h"
#include "port_rom.h"

static void put(uint8_t at[], uint32_t offset_counts)
{
    at[0] = (uint8_t)offset_counts;
    at[1] = (uint8_t)(offset_counts >> 8);
    at[2] = (uint8_t)(offset_counts >> 16);
}

void port_fir_take(fir_t *fir, int32_t sample_counts, const fir_config_t *twice)
{
    const uint8_t  size          = (uint8_t)(FIR_SAMPLE_BYTES * fir->config->taps); /* <= 192 */
    const uint32_t offset_counts = (uint32_t)(sample_counts - FIXED_COUNTS_MIN);    /* 0..2^24-1 */

    put(&fir->window[fir->next], offset_counts);
    if (fir->config == twice) { put(&fir->window[fir->next + size], offset_counts); }
    fir->next = (uint8_t)(fir->next + FIR_SAMPLE_BYTES);
    if (fir->next == size) { fir->next = 0U; }
}

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

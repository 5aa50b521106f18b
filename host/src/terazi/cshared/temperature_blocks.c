/* SPDX-License-Identifier: MIT */
#include "temperature_blocks.h"

void temperature_blocks_correct(temperature_t *temperature, const int32_t raw_counts[],
                                const int16_t measured_centi[], const uint8_t has_reading[],
                                int32_t corrected_counts[], size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        if (has_reading[at]) { temperature_update(temperature, measured_centi[at]); }
        corrected_counts[at] = temperature_correct(temperature, raw_counts[at]);
    }
}

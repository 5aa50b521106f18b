/* SPDX-License-Identifier: MIT */
/* temperature_blocks - the loop of the temperature compensation over arrays for Python. */
#ifndef TEMPERATURE_BLOCKS_H
#define TEMPERATURE_BLOCKS_H

#include <stddef.h>
#include <stdint.h>

#include "temperature.h"

/* A reading before a sample where has_reading says so. */
void temperature_blocks_correct(temperature_t *temperature, const int32_t raw_counts[],
                                const int16_t measured_centi[], const uint8_t has_reading[],
                                int32_t corrected_counts[], size_t count);

#endif

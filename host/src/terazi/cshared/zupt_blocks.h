/* SPDX-License-Identifier: MIT */
/* zupt_blocks - the loop of zupt over arrays for Python. */
#ifndef ZUPT_BLOCKS_H
#define ZUPT_BLOCKS_H

#include <stddef.h>
#include <stdint.h>

#include "zupt.h"

/* Vectors lie one behind the other: three values each. A flag after each sample. */
void zupt_blocks(zupt_t *zupt, const int16_t gyro_b_counts[], const int16_t acc_b_counts[],
                 uint8_t flags[], size_t count);

#endif

/* SPDX-License-Identifier: MIT */
/* zupt_gru_blocks - the loop of zupt_gru over arrays for Python. */
#ifndef ZUPT_GRU_BLOCKS_H
#define ZUPT_GRU_BLOCKS_H

#include <stddef.h>
#include <stdint.h>

#include "zupt_gru.h"

/* Vectors lie one behind the other: three values each. A flag after each sample. */
void zupt_gru_blocks(zupt_gru_t *gru, const int16_t gyro_b_counts[], const int16_t acc_b_counts[],
                     uint8_t flags[], size_t count);

#endif

/* SPDX-License-Identifier: MIT */
/* adaptive_blocks - loops of weight_kf_adaptive over arrays for Python. */
#ifndef ADAPTIVE_BLOCKS_H
#define ADAPTIVE_BLOCKS_H

#include <stddef.h>
#include <stdint.h>

#include "weight_kf_adaptive.h"

/* noise_q16: the noise as learnt after each measurement. */
void adaptive_blocks_kf(weight_kf_adaptive_t *kf, const int32_t measured[], int32_t estimates_q7[],
                        uint32_t noise_q16[], size_t count);
void adaptive_blocks_pair(weight_kf_adaptive_pair_t *pair, const int32_t measured[],
                          int32_t estimates_q7[], uint32_t noise_q16[], size_t count);

#endif

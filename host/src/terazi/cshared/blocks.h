/* SPDX-License-Identifier: MIT */
/* blocks - loops over arrays for Python: what a block call does a million times in C. */
#ifndef BLOCKS_H
#define BLOCKS_H

#include <stddef.h>
#include <stdint.h>

#include "fir.h"
#include "frame.h"
#include "weight_kf.h"

void blocks_fir(fir_t *fir, const int32_t samples[], int32_t results[], size_t count);
void blocks_weight_kf(weight_kf_t *kf, const int32_t measured[], int32_t estimates_q7[],
                      size_t count);
void blocks_mass(const int32_t kf_q7[], int32_t tare_q7, uint32_t span_ug_per_count_q16,
                 int32_t mass_mg[], size_t count);

/* Push bytes until a frame is ready or bad, or all are used: the status, and how many were used. */
frame_status_t blocks_decode(frame_decoder_t *decoder, const uint8_t bytes[], size_t count,
                             size_t *used);

#endif

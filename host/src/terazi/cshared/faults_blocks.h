/* SPDX-License-Identifier: MIT */
/* faults_blocks - the device's chain from events to a weight, over arrays for Python. */
#ifndef FAULTS_BLOCKS_H
#define FAULTS_BLOCKS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "faults.h"
#include "fir.h"
#include "scale.h"
#include "weight_kf_adaptive.h"

typedef struct {
    faults_t             faults;
    fir_t                fir;
    weight_kf_adaptive_t kf;
    scale_t             *scale;
    bool                 primed;  /* the filters hold a run of samples */
    bool                 watched; /* what faults finds is heeded */
} faults_blocks_t;

/* scale must stay. */
void faults_blocks_init(faults_blocks_t *chain, scale_t *scale);

/* Faults held, flags of the scale and its mass after each event. */
void faults_blocks_weigh(faults_blocks_t *chain, const uint8_t events[], const int32_t counts[],
                         const uint32_t device_us[], uint8_t held[], uint8_t flags[],
                         int32_t mass_mg[], size_t count);

#endif

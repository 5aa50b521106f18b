/* SPDX-License-Identifier: MIT */
/* scale_blocks - loops of scale and checkweigher over arrays for Python. */
#ifndef SCALE_BLOCKS_H
#define SCALE_BLOCKS_H

#include <stddef.h>
#include <stdint.h>

#include "checkweigher.h"
#include "scale.h"

/* Flags, net mass and what is shown after each sample. raw_q7 may be NULL: the counts. */
void scale_blocks_update(scale_t *scale, const int32_t raw_q7[], const int32_t counts_q7[],
                         const uint32_t device_us[], uint8_t flags[], int32_t net_mg[],
                         int32_t shown[], size_t count);

/* The mass of each, by the calibration's curve alone. */
void scale_blocks_mass(const scale_t *scale, const int32_t counts_q7[], int32_t mass_mg[],
                       size_t count);

/* Event and last weight after each mass. */
void scale_blocks_checkweigher(checkweigher_t *checkweigher, const int32_t mass_mg[],
                               const uint32_t device_us[], uint8_t events[], int32_t weighed_mg[],
                               size_t count);

#endif

/* SPDX-License-Identifier: MIT */
/* checkweigher_tone - the constant under one damped tone, in steps that a sample each has time for.
 * Internal to shared_c; what it computes stands in checkweigher.h and in the notes. */
#ifndef CHECKWEIGHER_TONE_H
#define CHECKWEIGHER_TONE_H

#include "checkweigher.h"

/* Smooth the masses held in their place: samples - 4 are left. */
void checkweigher_tone_smooth(checkweigher_t *checkweigher);

/* Put them about their mean, and so large that 13 bits are used; sets sum and up. */
void checkweigher_tone_level(checkweigher_t *checkweigher);

/* Sets moments. */
void checkweigher_tone_correlate(checkweigher_t *checkweigher);

/* The constant about base_mg, in half units. */
int32_t checkweigher_tone_solve(checkweigher_t *checkweigher);

#endif

/* SPDX-License-Identifier: MIT */
/* checkweigher_tone - the constant under one damped tone, in three steps that a sample each has
 * time for. Internal to shared_c; what it computes stands in checkweigher.h and in the notes. */
#ifndef CHECKWEIGHER_TONE_H
#define CHECKWEIGHER_TONE_H

#include "checkweigher.h"

enum { CHECKWEIGHER_OFF_MAX = 16384 }; /* what a mass too far off is kept as */

/* Smooth the first len of off in their place: len - 4 are left. False where one is too far off.
 * len is CHECKWEIGHER_SAMPLES_MIN.._MAX. */
bool checkweigher_tone_smooth(int16_t off[], uint8_t len);

/* Sum them up, spoiling them; sums may lie where they lie. */
void checkweigher_tone_sum(checkweigher_sums_t *sums, int16_t smooth[], uint8_t len);

/* The constant, Q8 of a unit: between the least and the greatest of the smoothed. */
int32_t checkweigher_tone_solve(const checkweigher_sums_t *sums);

#endif

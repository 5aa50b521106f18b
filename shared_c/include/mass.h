/* SPDX-License-Identifier: MIT */
/* mass - counts above the tare to milligrams, by a straight line through zero.
 *
 * Model     mass_mg = net_counts_q7 / 2^7 * span_ug_per_count_q16 / 2^16 / 1000
 * Result    exact in unbounded integers, then rounded half up to a milligram: nothing is lost
 *           between counts and mass but that one rounding
 * Formats   net: counts, Q7 in int32    span: ug/count, Q16 in uint32    mass: mg in int32
 * Bad data  every pair of arguments is lawful: the largest mass is 2^37 / 125 mg < 2^31 mg
 * Context   any; no state.  Cost: firmware/budget.toml
 */
#ifndef MASS_H
#define MASS_H

#include <stdint.h>

/* 5 kg over 1 mV/V at gain 128: 2.328 mg a count, the span of a board that was never calibrated. */
enum { MASS_DEFAULT_SPAN_UG_PER_COUNT = 2328 };

int32_t mass_from_counts(int32_t net_counts_q7, uint32_t span_ug_per_count_q16);

#endif

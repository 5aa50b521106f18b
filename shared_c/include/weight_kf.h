/* SPDX-License-Identifier: MIT */
/* weight_kf - scalar Kalman filter for the load on the scale, a random walk seen in white noise.
 *
 * Model     x' = x + w,  z = x + v,  var w = Q,  var v = R
 *           P = P + Q;  K = P / (P + R);  x = x + K (z - x);  P = (1 - K) P
 *           (weighing thesis, eq. 3.7-3.11)
 * Gain      does not depend on data: tools/gen computes the schedule K[0..len-1] from
 *           spec/weight_kf.toml and the last one is held, so that nothing is divided here
 * Formats   measurement: counts, |z| <= 2^23, in int32    estimate: counts, Q7 in int32
 *           gain: Q15, 1..32768 (32768 is 1)
 * Rounding  half up, once an update
 * Bad data  a measurement beyond 24 bits is clamped and counted in `clipped`; update cannot fail
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef WEIGHT_KF_H
#define WEIGHT_KF_H

#include <stdint.h>

enum { WEIGHT_KF_FRACTION_BITS = 7 };

typedef struct {
    const uint16_t *gain_q15; /* ROM */
    uint8_t         gain_len; /* 1..255 */
} weight_kf_config_t;

typedef struct {
    const weight_kf_config_t *config;
    int32_t                   estimate_counts_q7; /* |.| <= 2^30 */
    uint8_t                   step;               /* index of the next gain, 0..gain_len-1 */
    uint16_t                  clipped; /* measurements clamped to 24 bits, stops at 65535 */
} weight_kf_t;

/* Start at first_counts with the first gain of the schedule. */
void weight_kf_init(weight_kf_t *kf, const weight_kf_config_t *config, int32_t first_counts);

/* Take one measurement, give the new estimate (Q7). */
int32_t weight_kf_update(weight_kf_t *kf, int32_t measured_counts);

#endif

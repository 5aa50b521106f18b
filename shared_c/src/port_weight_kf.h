/* SPDX-License-Identifier: MIT */
/* port_weight_kf - the Kalman filter's step, which is nearly all that it costs. Part of the seam.
 *
 * Model     estimate_q7 += floor((gain_q15 * (2^7 counts - estimate_q7) + 2^14) / 2^15) in
 *           unbounded integers; gives the new estimate
 * Formats   estimate: counts, Q7, |.| <= 2^30    counts: |.| <= 2^23    gain: Q15, 1..32768
 * Bounds    |2^7 counts - estimate_q7| <= 2^31 - 2^7: the difference fits in int32, and as the gain
 *           is at most one, so does what is added
 */
#ifndef PORT_WEIGHT_KF_H
#define PORT_WEIGHT_KF_H

#include <stdint.h>

/* gain_q15: one gain, in ROM. */
int32_t port_weight_kf_step(int32_t *estimate_q7, int32_t counts, const uint16_t *gain_q15);

#endif

/* SPDX-License-Identifier: MIT */
/* port_weight_kf - the Kalman filter's update, which is all that it costs. Part of the seam.
 *
 * Model     estimate_q7 += floor((gain_q15 * (2^7 counts - estimate_q7) + 2^14) / 2^15) in
 *           unbounded integers; gives the new estimate. The gain is that of this step; the next
 *           step has the schedule's next, or holds the last
 * Formats   estimate: counts, Q7, |.| <= 2^30    gain: Q15, 1..32768
 *           counts: clamped to 24 bits, and counted, as port_clamp_counts does
 * Bounds    |2^7 counts - estimate_q7| <= 2^31 - 2^7: the difference fits in int32, and as the gain
 *           is at most one, so does what is added
 */
#ifndef PORT_WEIGHT_KF_H
#define PORT_WEIGHT_KF_H

#include <stdint.h>

#include "weight_kf.h"

int32_t port_weight_kf_step(weight_kf_t *kf, int32_t measured_counts);

#endif

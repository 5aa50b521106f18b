/* SPDX-License-Identifier: MIT */
/* port_weight_kf_adaptive - a step of the adaptive filter, which is all of it but the clamping.
 * Part of the seam.
 *
 * Model     the header's test, update and learn, for a measurement within 24 bits. In integers,
 *           with >> for the floor of a division by a power of two:
 *             sigma = noise_q16 >> 8;  below = z < x;  z and the two before it as distances from x,
 *             positive on the side of z;  J = max(0, least of them - (margin_sigmas sigma >> 1))
 *             l = min(|z - x| - J, 2 sigma), which in Q7 is 4 sigma;  j = min(J >> 2, 65535), in Q5
 *             R = sigma^2;  P = var_q16 + process_var_q16;  S = P + R;  N = j sigma
 *             2^16 min(max(N, P), S) = K S + rest,  0 <= rest < S,  but K 2^16 - 1 at most
 *             var_q16 = N > P ? (K R + 2^15) >> 16 : P - ((K (P + (rest >> 16)) + 2^15) >> 16)
 *             (the rest makes good what K lacks: the variance is that of the K that is applied)
 *             x + fraction_q23 moves by J + K l to the side of z, l K in Q23; x is its floor in Q7
 *             cap = max(4 ((sigma >> 1) - j), sigma >> 1)
 *             noise_q16 += (642 min(l, cap) - noise_q16 + 2^7) >> 8, kept within its bounds
 *             (642 is sqrt(pi/2) in Q9, a normal deviate's sigma over its mean magnitude)
 * Bounds    distances <= 2^31 - 2^7;  sigma < 2^15, so that R < 2^30 and S < 2^31
 */
#ifndef PORT_WEIGHT_KF_ADAPTIVE_H
#define PORT_WEIGHT_KF_ADAPTIVE_H

#include <stdint.h>

#include "weight_kf_adaptive.h"

/* Gives the new estimate. */
int32_t port_weight_kf_adaptive_step(weight_kf_adaptive_t *kf, int32_t counts,
                                     uint8_t margin_sigmas);

#endif

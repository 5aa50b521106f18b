/* SPDX-License-Identifier: MIT */
/* port_curve - the calibration's curve, which is a third of scale's time. Part of the seam.
 *
 * Model     with c = counts_q7 limited to 31 bits and x = c, or -c where counts fall with mass:
 *           i is the last but one of the points or, of those before it, the last whose x is not
 *           beyond, or else the first;  rise = min(floor((|x - x_i| slope_i + 2^31) / 2^32),
 *           3 * 2^29 - 1);  mass = m_i + rise, or m_i - rise where x < x_i, limited to 31 bits
 * Bounds    points in 31 bits, so that |x - x_i| < 2^31;  slope in Q32 below 1;  |m_i| <= 2^29, so
 *           that the sum fits in int32 and still reaches the ends of 31 bits on either side
 */
#ifndef PORT_CURVE_H
#define PORT_CURVE_H

#include "scale.h"

int32_t port_curve(const scale_t *scale, int32_t counts_q7);

#endif

/* SPDX-License-Identifier: MIT */
/* port_mass - the product and the division of mass.c, wider than 32 bits. Part of the seam.
 *
 * Model     floor((counts_q7 * span_q16 + half) / (125 * 2^26)) in unbounded integers
 *           (125 * 2^26 is the 2^7 * 2^16 * 1000 of mass.h)
 * Bounds    counts_q7 <= 2^31, so that the result is at most 2^37 / 125 < 2^31
 */
#ifndef PORT_MASS_H
#define PORT_MASS_H

#include <stdint.h>

uint32_t port_mass_scale(uint32_t counts_q7, uint32_t span_q16, uint32_t half);

#endif

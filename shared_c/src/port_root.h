/* SPDX-License-Identifier: MIT */
/* port_root - roots and ratios bit by bit: small, for what happens seldom. */
#ifndef PORT_ROOT_H
#define PORT_ROOT_H

#include <stdint.h>

/* floor(sqrt(value)).  value < 2^30 */
uint16_t port_root(uint32_t value);

/* floor(2^15 part / whole).  part <= whole, 0 < whole < 2^15 */
uint16_t port_ratio_q15(uint16_t part, uint16_t whole);

#endif

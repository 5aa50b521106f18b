/* SPDX-License-Identifier: MIT */
/* port_wide - the upper half of a 64-bit product, and a quotient. Plain: port_plain/port_wide.c.
 * AVR: assembler. */
#ifndef PORT_WIDE_H
#define PORT_WIDE_H

#include <stdint.h>

/* floor((a * b + 2^31) / 2^32): half up, and below 2^32 for all a and b. */
uint32_t port_wide_high(uint32_t a, uint32_t b);

/* value * share / 2^32, half away from zero. */
int32_t port_wide_share(int32_t value, uint32_t share_q32);

/* floor(a * 2^32 / b) for a < b <= 2^31; for a = b just below 2^32. Bit by bit: for configuration
 * and commands. */
uint32_t port_wide_ratio(uint32_t a, uint32_t b);

#endif

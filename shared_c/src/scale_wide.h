/* SPDX-License-Identifier: MIT */
/* scale_wide - 64-bit quotients for scale and checkweigher, without the 64-bit
 * routines of avr-gcc, which are large and slow. Internal to shared_c. */
#ifndef SCALE_WIDE_H
#define SCALE_WIDE_H

#include <stdint.h>

/* floor(a * 2^32 / b) for a < b <= 2^31, bit by bit: for configuration and commands. */
uint32_t scale_wide_ratio(uint32_t a, uint32_t b);

#endif

/* SPDX-License-Identifier: MIT */
/* scale_wide - 64-bit products and quotients for scale and checkweigher, without the 64-bit
 * routines of avr-gcc, which are large and slow. Internal to shared_c. */
#ifndef SCALE_WIDE_H
#define SCALE_WIDE_H

#include <stdint.h>

typedef struct {
    uint32_t low;
    uint32_t high;
} scale_wide_t;

/* a * b, all 64 bits. */
scale_wide_t scale_wide_product(uint32_t a, uint32_t b);

/* floor(a * 2^32 / b) for a < b <= 2^31, bit by bit: for configuration and commands. */
uint32_t scale_wide_ratio(uint32_t a, uint32_t b);

#endif

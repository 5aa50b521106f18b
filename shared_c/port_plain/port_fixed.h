/* SPDX-License-Identifier: MIT */
/* port_fixed - the wide multiplication, where the 8-bit machine is helped by hand. Plain: int64. */
#ifndef PORT_FIXED_H
#define PORT_FIXED_H

#include <stdint.h>

/* a * b, all 32 bits. */
static inline uint32_t port_mul_u16(uint16_t a, uint16_t b)
{
    return (uint32_t)a * b;
}

/* floor((value * gain_q15 + 2^14) / 2^15).  gain_q15 <= 32768; |product| <= 2^46 */
static inline int32_t port_mul_q15(int32_t value, uint16_t gain_q15)
{
    return (int32_t)(((int64_t)value * gain_q15 + (1 << 14)) >> 15);
}

#endif

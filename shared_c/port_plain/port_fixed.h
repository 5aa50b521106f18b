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

/* a * b, signed, all 32 bits. */
static inline int32_t port_mul_i16(int16_t a, int16_t b)
{
    return (int32_t)a * b;
}

/* a * b with |a| < 2^23; the caller bounds the product to 32 bits. */
static inline int32_t port_mul_i24(int32_t a, int16_t b)
{
    return a * b;
}

/* a^2, unsigned, so that sums of three fit. */
static inline uint32_t port_square_i16(int16_t a)
{
    return (uint32_t)((int32_t)a * a);
}

/* floor((value * gain_q15 + 2^14) / 2^15).  gain_q15 <= 32768; |product| <= 2^46 */
static inline int32_t port_mul_q15(int32_t value, uint16_t gain_q15)
{
    return (int32_t)(((int64_t)value * gain_q15 + (1 << 14)) >> 15);
}

#endif

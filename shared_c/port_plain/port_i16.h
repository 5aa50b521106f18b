/* SPDX-License-Identifier: MIT */
/* port_i16 - sums of 16-bit products, and sums that saturate. Plain: int32. */
#ifndef PORT_I16_H
#define PORT_I16_H

#include <stdint.h>

/* sum + a * b; the caller knows that it fits. */
static inline int32_t port_mac_i16(int32_t sum, int16_t a, int16_t b)
{
    return sum + (int32_t)a * b;
}

static inline int16_t port_sat_i16(int32_t value)
{
    if (value > INT16_MAX) { return INT16_MAX; }
    return value < INT16_MIN ? INT16_MIN : (int16_t)value;
}

/* a + b, limited to int16. */
static inline int16_t port_add_sat_i16(int16_t a, int16_t b)
{
    return port_sat_i16((int32_t)a + b);
}

/* a - b, limited to int16. */
static inline int16_t port_sub_sat_i16(int16_t a, int16_t b)
{
    return port_sat_i16((int32_t)a - b);
}

#endif

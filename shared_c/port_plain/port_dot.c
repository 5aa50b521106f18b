/* SPDX-License-Identifier: MIT */
/* port_dot - the inner product of two vectors of three. Plain: as src/port_dot.h says it. */
#include "port_dot.h"

int32_t port_dot(const int16_t a[3], const int16_t b[3])
{
    return (int32_t)a[0] * b[0] + (int32_t)a[1] * b[1] + (int32_t)a[2] * b[2];
}

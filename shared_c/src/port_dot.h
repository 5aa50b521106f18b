/* SPDX-License-Identifier: MIT */
/* port_dot - the inner product of two vectors of three, in 32 bits; the caller bounds it. */
#ifndef PORT_DOT_H
#define PORT_DOT_H

#include <stdint.h>

int32_t port_dot(const int16_t a[3], const int16_t b[3]);

#endif

/* SPDX-License-Identifier: MIT */
/* port_clamp - what is done to counts in many places. Plain: port_plain/port_clamp.c. AVR:
 * assembler, one copy for all. */
#ifndef PORT_CLAMP_H
#define PORT_CLAMP_H

#include <stdint.h>

/* Count one more event; a counter stops at its maximum rather than lie by wrapping. */
void port_count(uint16_t *counter);

/* value inside the converter's 24 bits; each clamped value is counted. */
int32_t port_clamp_counts(int32_t value, uint16_t *clipped);

/* value * 2^7, modulo 2^32; and back, to the nearest, half up: value < 2^31 - 2^6. */
int32_t port_to_q7(int32_t value);
int32_t port_from_q7(int32_t value_q7);

#endif

/* SPDX-License-Identifier: MIT */
/* port_clamp - what every filter does to what it is fed. Plain: port_plain/port_clamp.c. AVR:
 * assembler, one copy for all. */
#ifndef PORT_CLAMP_H
#define PORT_CLAMP_H

#include <stdint.h>

/* Count one more event; a counter stops at its maximum rather than lie by wrapping. */
void port_count(uint16_t *counter);

/* value inside the converter's 24 bits; each clamped value is counted. */
int32_t port_clamp_counts(int32_t value, uint16_t *clipped);

#endif

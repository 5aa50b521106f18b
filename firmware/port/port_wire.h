/* SPDX-License-Identifier: MIT */
/* port_wire - whether a struct of messages.h lies in memory as its payload does on the wire: fields
 * little-endian and without padding. AVR: it does, so that the codec is a copy. */
#ifndef PORT_WIRE_H
#define PORT_WIRE_H

#define PORT_WIRE_IS_STRUCT 1

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "a copy is no codec");

#endif

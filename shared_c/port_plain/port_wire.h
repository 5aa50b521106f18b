/* SPDX-License-Identifier: MIT */
/* port_wire - whether a struct of messages.h lies in memory as its payload does on the wire: fields
 * little-endian and without padding. Plain: nothing is known of the machine, so it does not. */
#ifndef PORT_WIRE_H
#define PORT_WIRE_H

#define PORT_WIRE_IS_STRUCT 0

#endif

/* SPDX-License-Identifier: MIT */
/* port_reach - a pointer whose value the compiler need not know. Plain: as any. */
#ifndef PORT_REACH_H
#define PORT_REACH_H

#define PORT_REACH(pointer) (pointer)

#endif

/* SPDX-License-Identifier: MIT */
/* port_reach - a pointer whose value gcc does not know. Where it knows the address it takes every
 * field from there, twice the code of one that it reaches by the pointer. AVR: a base register. */
#ifndef PORT_REACH_H
#define PORT_REACH_H

#define PORT_REACH(pointer)                     \
    __extension__({                             \
        __typeof__(pointer) reach_ = (pointer); \
        __asm__("" : "+b"(reach_));             \
        reach_;                                 \
    })

#endif

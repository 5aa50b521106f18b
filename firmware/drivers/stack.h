/* SPDX-License-Identifier: MIT */
/* stack - how much of the stack's room was never touched.
 *
 * Model     before main the room between static data and the stack pointer is painted; what still
 *           bears the paint was never used. There is no heap.
 * Context   main loop; about 9 cycles a free byte
 */
#ifndef STACK_H
#define STACK_H

#include <stdint.h>

uint16_t stack_free_bytes(void);

#endif

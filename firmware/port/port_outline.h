/* SPDX-License-Identifier: MIT */
/* port_outline - a function that is kept whole: one whose cost is measured, or whose registers do
 * not belong on the usual path. AVR: never inlined, even at link time. */
#ifndef PORT_OUTLINE_H
#define PORT_OUTLINE_H

#define PORT_OUTLINE __attribute__((noinline))

/* At the head of a function that keeps much over calls. AVR: its registers are saved by the one
 * routine that there is for that, half the code, which gcc calls only where of r29, r28, r17 and so
 * on none is left out: r16, r17 it may leave out. */
#define PORT_SAVE_BY_CALL() __asm__ volatile("" ::: "r16", "r17")

#endif

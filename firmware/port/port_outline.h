/* SPDX-License-Identifier: MIT */
/* port_outline - a function that is kept whole: one whose cost is measured, or whose registers do
 * not belong on the usual path. AVR: never inlined, even at link time. */
#ifndef PORT_OUTLINE_H
#define PORT_OUTLINE_H

#define PORT_OUTLINE __attribute__((noinline))

#endif

/* SPDX-License-Identifier: MIT */
/* port_hot - what follows this include, to the end of the source, is compiled for speed: the image
 * as a whole is compiled for size. PORT_OUTLINE keeps a function whole: one whose cost is measured,
 * or whose registers do not belong on the usual path. */
#ifndef PORT_HOT_H
#define PORT_HOT_H

#define PORT_OUTLINE __attribute__((noinline))

#pragma GCC optimize("O2,gcse,move-loop-invariants")

#endif

/* SPDX-License-Identifier: MIT */
/* port_hot - what follows this include, to the end of the source, is compiled for speed: the image
 * as a whole is compiled for size. */
#ifndef PORT_HOT_H
#define PORT_HOT_H

#include "port_outline.h"

#pragma GCC optimize("O2,gcse,move-loop-invariants")

#endif

/* SPDX-License-Identifier: MIT */
/* port_hot - compiled for speed. Plain: as everything is. */
#ifndef PORT_HOT_H
#define PORT_HOT_H

#include "port_outline.h"

#endif

/* SPDX-License-Identifier: MIT */
/* port_hot - compiled for speed, and whole. Plain: as everything is. */
#ifndef PORT_HOT_H
#define PORT_HOT_H

#define PORT_OUTLINE

#endif

/* SPDX-License-Identifier: MIT */
/* port_outline - a function that is kept whole: one whose cost is measured. Plain: as any. */
#ifndef PORT_OUTLINE_H
#define PORT_OUTLINE_H

#define PORT_OUTLINE

#define PORT_SAVE_BY_CALL() ((void)0)

#endif

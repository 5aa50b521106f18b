/* SPDX-License-Identifier: MIT */
/* port_assert - wiring mistakes, that is, arguments that no data can cause. Plain: assert(). */
#ifndef PORT_ASSERT_H
#define PORT_ASSERT_H

#include <assert.h>

#define PORT_ASSERT(condition) assert(condition)

#endif

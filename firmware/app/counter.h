/* SPDX-License-Identifier: MIT */
/* counter - counts that stop at their maximum instead of starting over.
 *
 * Context   single caller
 */
#ifndef COUNTER_H
#define COUNTER_H

#include <stdint.h>

void counter_add(uint16_t *counter, uint16_t events);

#endif

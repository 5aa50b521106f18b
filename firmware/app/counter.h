/* SPDX-License-Identifier: MIT */
/* counter - counts that stop at their maximum instead of starting over.
 *
 * Context   single caller
 */
#ifndef COUNTER_H
#define COUNTER_H

#include <stdint.h>

static inline void counter_add(uint16_t *counter, uint16_t events)
{
    const uint16_t room = (uint16_t)(UINT16_MAX - *counter);

    *counter = (uint16_t)(*counter + (events < room ? events : room));
}

#endif

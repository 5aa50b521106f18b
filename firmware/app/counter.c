/* SPDX-License-Identifier: MIT */
#include "counter.h"

__attribute__((noinline)) void counter_add(uint16_t *counter, uint16_t events)
{
    const uint16_t sum = (uint16_t)(*counter + events);

    *counter = sum < events ? UINT16_MAX : sum;
}

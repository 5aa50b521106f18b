/* SPDX-License-Identifier: MIT */
#include "port_wide.h"

uint32_t port_wide_high(uint32_t a, uint32_t b)
{
    return (uint32_t)(((uint64_t)a * b + 0x80000000U) >> 32);
}

/* SPDX-License-Identifier: MIT */
#include "port_mass.h"

uint32_t port_mass_scale(uint32_t counts_q7, uint32_t span_q16, uint32_t half)
{
    return (uint32_t)(((uint64_t)counts_q7 * span_q16 + half) / (UINT64_C(125) << 26));
}

/* SPDX-License-Identifier: MIT */
#include "port_weight_kf.h"

#include "port_fixed.h"
#include "port_rom.h"

int32_t port_weight_kf_step(int32_t *estimate_q7, int32_t counts, const uint16_t *gain_q15)
{
    *estimate_q7 += port_mul_q15(counts * 128 - *estimate_q7, port_rom_u16(gain_q15));
    return *estimate_q7;
}

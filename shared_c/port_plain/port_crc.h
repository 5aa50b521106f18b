/* SPDX-License-Identifier: MIT */
/* port_crc - one byte into CRC-16/MCRF4XX (polynomial 0x1021 reflected, no final inversion).
 * Plain: bit by bit, after the definition. */
#ifndef PORT_CRC_H
#define PORT_CRC_H

#include <stdint.h>

#define PORT_CRC16_START UINT16_C(0xFFFF)

static inline uint16_t port_crc16(uint16_t crc, uint8_t byte)
{
    crc ^= byte;
    for (uint8_t bit = 0U; bit < 8U; ++bit) {
        crc = (uint16_t)((crc & 1U) != 0U ? (crc >> 1) ^ 0x8408U : crc >> 1);
    }
    return crc;
}

#endif

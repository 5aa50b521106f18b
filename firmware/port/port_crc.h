/* SPDX-License-Identifier: MIT */
/* port_crc - one byte into CRC-16/MCRF4XX. AVR: avr-libc's, which needs no table. */
#ifndef PORT_CRC_H
#define PORT_CRC_H

#include <stdint.h>
#include <util/crc16.h>

#define PORT_CRC16_START UINT16_C(0xFFFF)

static inline uint16_t port_crc16(uint16_t crc, uint8_t byte)
{
    return _crc_ccitt_update(crc, byte);
}

#endif

/* SPDX-License-Identifier: MIT */
/* port_rom - constant tables. Plain: ordinary memory. AVR: program memory, read by LPM. */
#ifndef PORT_ROM_H
#define PORT_ROM_H

#include <stdint.h>

#define PORT_ROM

typedef uint16_t port_place_t; /* of a member in a struct */

static inline uint8_t port_rom_u8(const uint8_t *at)
{
    return *at;
}

static inline port_place_t port_rom_place(const port_place_t *at)
{
    return *at;
}

static inline uint16_t port_rom_u16(const uint16_t *at)
{
    return *at;
}

static inline int16_t port_rom_i16(const int16_t *at)
{
    return *at;
}

#endif

/* SPDX-License-Identifier: MIT */
/* port_rom - constant tables. AVR: program memory, read by LPM, so that they cost no RAM. */
#ifndef PORT_ROM_H
#define PORT_ROM_H

#include <avr/pgmspace.h>
#include <stdint.h>

#define PORT_ROM PROGMEM

typedef uint8_t port_place_t; /* of a member in a struct, which no padding makes longer here */

static inline uint8_t port_rom_u8(const uint8_t *at)
{
    return pgm_read_byte(at);
}

static inline port_place_t port_rom_place(const port_place_t *at)
{
    return pgm_read_byte(at);
}

static inline uint16_t port_rom_u16(const uint16_t *at)
{
    return pgm_read_word(at);
}

static inline int16_t port_rom_i16(const int16_t *at)
{
    return (int16_t)pgm_read_word(at);
}

#endif

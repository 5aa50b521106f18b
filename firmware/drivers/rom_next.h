/* SPDX-License-Identifier: MIT */
/* rom_next - bytes of program memory in a row; gcc would reckon each address anew. */
#ifndef ROM_NEXT_H
#define ROM_NEXT_H

#include <stdint.h>

static inline __attribute__((always_inline)) uint8_t rom_next(const uint8_t **at)
{
    uint8_t byte;

    __asm__("lpm %0, %a1+" : "=&r"(byte), "+z"(*at));
    return byte;
}

#endif

/* SPDX-License-Identifier: MIT */
#include "hx711.h"
#include "port_outline.h"
#include "uno_pins.h"

#include <avr/io.h>

/* A pulse is high for 4 cycles = 0.25 us (T3: 0.2 .. 50 us), two of which do some work, and low for
 * at least 6 (T4: 0.2 us), HX711 datasheet p. 5. Interrupts are off for 7 cycles: what delays this
 * code in between only makes the low phase longer, which has no upper limit. DOUT is valid 0.1 us
 * after PD_SCK rises (T2) and stays until it rises again.
 *
 * A byte a turn: a turn for each bit would cost as much again as the pulses. What ends the loop
 * falls into the carry, which no bit touches. Each byte is put down in the pulses of the next: the
 * first to be put down is none, and stands where the sign goes. */
PORT_OUTLINE bool hx711_read(int32_t *counts, uint8_t extra_pulses)
{
    uint8_t *at      = (uint8_t *)counts + sizeof *counts;
    bool     at_rest = true;
    uint8_t  byte, before, turns;

    __asm__ volatile("ldi  %[turns], 0x20       \n" /* three turns */
                     "1:                        \n\t"
                     ".irp bit, 7, 6, 5, 4, 3, 2, 1, 0 \n\t"
                     "cli                       \n\t"
                     "sbi  %[port], %[sck]      \n\t"
                     ".if  \\bit == 7           \n\t"
                     "mov  %[before], %[byte]   \n\t"
                     "clr  %[byte]              \n\t"
                     ".elseif \\bit == 6        \n\t"
                     "st   -%a[at], %[before]   \n\t"
                     ".elseif \\bit == 0        \n\t"
                     "lsl  %[turns]             \n\t"
                     "nop                       \n\t"
                     ".else                     \n\t"
                     "rjmp .                    \n\t"
                     ".endif                    \n\t"
                     "cbi  %[port], %[sck]      \n\t"
                     "sei                       \n\t"
                     "sbic %[pin], %[dout]      \n\t"
                     "ori  %[byte], 1 << \\bit  \n\t"
                     ".endr                     \n\t"
                     "brcc 1b                   \n\t"
                     "st   -%a[at], %[byte]     \n"
                     "2:                        \n\t"
                     "cli                       \n\t"
                     "sbi  %[port], %[sck]      \n\t"
                     "ldd  %[byte], %a[at]+2    \n\t" /* the highest */
                     "cbi  %[port], %[sck]      \n\t"
                     "sei                       \n\t"
                     "sbis %[pin], %[dout]      \n\t"
                     "clr  %[at_rest]           \n\t"
                     "dec  %[extra]             \n\t"
                     "brne 2b                   \n\t"
                     "lsl  %[byte]              \n\t"
                     "sbc  %[byte], %[byte]     \n\t"
                     "std  %a[at]+3, %[byte]    \n\t"
                     : [at] "+&z"(at), [at_rest] "+&r"(at_rest), [extra] "+&r"(extra_pulses),
                       [byte] "=&d"(byte), [before] "=&r"(before), [turns] "=&d"(turns)
                     : [port] "I"(_SFR_IO_ADDR(HX711_PORT)), [pin] "I"(_SFR_IO_ADDR(HX711_PIN)),
                       [sck] "I"(HX711_PD_SCK), [dout] "I"(HX711_DOUT)
                     : "memory");
    return at_rest;
}

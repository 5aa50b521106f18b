/* SPDX-License-Identifier: MIT */
#include "hx711.h"
#include "port_hot.h"
#include "uno_pins.h"

#include <avr/cpufunc.h>
#include <avr/interrupt.h>
#include <avr/io.h>

/* One PD_SCK pulse. High for 4 cycles = 0.25 us (T3: 0.2 .. 50 us), low for at least 6 (T4: 0.2
 * us), HX711 datasheet p. 5. Interrupts are off for 7 cycles: what delays this code in between
 * only makes PD_SCK's low phase longer, which has no upper limit. */
#define PULSE()                                    \
    do {                                           \
        cli();                                     \
        HX711_PORT |= _BV(HX711_PD_SCK);           \
        _NOP();                                    \
        _NOP();                                    \
        HX711_PORT &= (uint8_t)~_BV(HX711_PD_SCK); \
        sei();                                     \
    } while (0)

/* DOUT is valid 0.1 us after PD_SCK rises (T2) and stays until it rises again. */
#define READ_BIT(byte, bit)                                              \
    do {                                                                 \
        PULSE();                                                         \
        if ((HX711_PIN & _BV(HX711_DOUT)) != 0U) { (byte) |= _BV(bit); } \
    } while (0)

#define READ_BYTE(byte)    \
    do {                   \
        READ_BIT(byte, 7); \
        READ_BIT(byte, 6); \
        READ_BIT(byte, 5); \
        READ_BIT(byte, 4); \
        READ_BIT(byte, 3); \
        READ_BIT(byte, 2); \
        READ_BIT(byte, 1); \
        READ_BIT(byte, 0); \
    } while (0)

/* A register that holds 0 and of which gcc knows nothing: otherwise it turns the first bit of each
 * byte into a branch, which costs 3 cycles more and makes the time depend on the data. */
#define CLEARED(name) \
    uint8_t name;     \
    __asm__("clr %0" : "=r"(name))

/* Unrolled: a loop would cost as much again as the pulses themselves. */
PORT_OUTLINE bool hx711_read(int32_t *counts, uint8_t extra_pulses)
{
    bool at_rest = true;
    CLEARED(high);
    CLEARED(middle);
    CLEARED(low);

    READ_BYTE(high);
    READ_BYTE(middle);
    READ_BYTE(low);
    do {
        PULSE();
        if ((HX711_PIN & _BV(HX711_DOUT)) == 0U) { at_rest = false; }
    } while (--extra_pulses != 0U);

    const union {
        uint8_t bytes[4];
        int32_t value;
    } joined = {.bytes = {low, middle, high, (high & 0x80U) != 0U ? 0xFFU : 0U}};

    *counts = joined.value;
    return at_rest;
}

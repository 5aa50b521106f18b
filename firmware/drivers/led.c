/* SPDX-License-Identifier: MIT */
#include "led.h"

#include "uno_pins.h"

void led_init(void)
{
    LED_DDR |= _BV(LED_BIT);
    led_set(true);
}

void led_set(bool on)
{
    if (on) {
        LED_PORT |= _BV(LED_BIT);
    } else {
        LED_PORT &= (uint8_t)~_BV(LED_BIT);
    }
}

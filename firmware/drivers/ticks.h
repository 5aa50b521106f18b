/* SPDX-License-Identifier: MIT */
/* ticks - the device's clock: Timer1 at 2 MHz, extended by its overflow interrupt.
 *
 * Model     Timer1 counts 16 MHz / 8 and overflows every 32.768 ms (ATmega328P datasheet, ch. 16)
 * Formats   device_us: us since reset in uint32, wraps after 71.6 minutes; compare by difference
 *           tick: 0.5 us in uint16, wraps after 32.768 ms
 * Context   ticks_device_us: main loop, interrupts on or off; ticks_device_us_in_isr: interrupts
 *           off. An interrupt is held back for at most 20 cycles.
 */
#ifndef TICKS_H
#define TICKS_H

#include <stdint.h>

/* Start the timer and its interrupt. */
void ticks_init(void);

uint32_t ticks_device_us(void);

/* The same where interrupts are off already; the timer is read first, within 10 cycles. */
uint32_t ticks_device_us_in_isr(void);

#endif

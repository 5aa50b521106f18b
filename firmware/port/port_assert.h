/* SPDX-License-Identifier: MIT */
/* port_assert - wiring mistakes. AVR: stand still with interrupts off until the watchdog resets,
 * so that a mistake shows as the reset cause `watchdog` in HELLO. */
#ifndef PORT_ASSERT_H
#define PORT_ASSERT_H

#include <avr/interrupt.h>
#include <stdbool.h>

#define PORT_ASSERT(condition) \
    do {                       \
        if (!(condition)) {    \
            cli();             \
            while (true) {}    \
        }                      \
    } while (false)

#endif

/* SPDX-License-Identifier: MIT */
/* watchdog - resets the chip if the main loop hangs for 0.5 s, and tells why it last started.
 *
 * Model     MCUSR is saved and cleared before main, and the watchdog stopped: after a watchdog
 *           reset it runs on at 16 ms (ATmega328P datasheet, 11.9.1)
 * Bad data  a boot loader that clears MCUSR leaves WATCHDOG_CAUSE_UNKNOWN
 * Context   main loop
 */
#ifndef WATCHDOG_H
#define WATCHDOG_H

typedef enum {
    WATCHDOG_CAUSE_UNKNOWN,
    WATCHDOG_CAUSE_POWER_ON,
    WATCHDOG_CAUSE_EXTERNAL,
    WATCHDOG_CAUSE_BROWN_OUT,
    WATCHDOG_CAUSE_WATCHDOG
} watchdog_cause_t;

void watchdog_start(void);
void watchdog_feed(void);

watchdog_cause_t watchdog_reset_cause(void);

#endif

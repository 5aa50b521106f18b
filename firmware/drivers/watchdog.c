/* SPDX-License-Identifier: MIT */
#include "watchdog.h"

#include <avr/io.h>
#include <avr/wdt.h>
#include <stdint.h>

/* Written before .bss is cleared, hence not part of it; read by watchdog_reset_cause. */
static volatile uint8_t reset_flags __attribute__((section(".noinit")));

/* Runs between the stack pointer's set-up and the clearing of .bss; falls through, hence naked. */
void watchdog_save_cause(void) __attribute__((naked, used, section(".init3")));
void watchdog_save_cause(void)
{
    reset_flags = MCUSR;
    MCUSR       = 0; /* while WDRF stands the watchdog cannot be stopped */
    wdt_disable();
}

void watchdog_start(void)
{
    wdt_enable(WDTO_500MS);
}

void watchdog_feed(void)
{
    wdt_reset();
}

watchdog_cause_t watchdog_reset_cause(void)
{
    const uint8_t flags = reset_flags;

    /* Power-on may set the others too, and a reset pin held through a brown-out both: the
     * deepest cause is the one to name. */
    if ((flags & _BV(PORF)) != 0U) { return WATCHDOG_CAUSE_POWER_ON; }
    if ((flags & _BV(BORF)) != 0U) { return WATCHDOG_CAUSE_BROWN_OUT; }
    if ((flags & _BV(WDRF)) != 0U) { return WATCHDOG_CAUSE_WATCHDOG; }
    if ((flags & _BV(EXTRF)) != 0U) { return WATCHDOG_CAUSE_EXTERNAL; }
    return WATCHDOG_CAUSE_UNKNOWN;
}

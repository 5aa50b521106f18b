/* SPDX-License-Identifier: MIT */
/* Asks the thermometer every 98 ms, the third overflow of the clock; notes what it says, and how
 * long that takes. */
#include "thermometer.h"
#include "idle.h"
#include "ticks.h"
#include "twi.h"
#include "uno_pins.h"

volatile int16_t  centi;
volatile uint16_t readings, missing;
volatile uint16_t longest_ticks; /* of 0.5 us: one call of thermometer_poll */
volatile uint16_t recoveries;

int main(void)
{
    uint32_t asked_us = 0;

    ticks_init();
    thermometer_init();
    idle_init();
    for (;;) {
        idle_clear_work();
        const uint32_t now_us = ticks_device_us();
        if (now_us - asked_us >= 90000UL) {
            asked_us = now_us;
            thermometer_ask(now_us);
        }
        int16_t                    now_centi;
        const uint16_t             before = TCNT1;
        const thermometer_status_t status = thermometer_poll(&now_centi, now_us);
        const uint16_t             took   = (uint16_t)(TCNT1 - before);
        if (took > longest_ticks) { longest_ticks = took; }
        if (status == THERMOMETER_READING) {
            centi = now_centi;
            readings++;
        } else if (status == THERMOMETER_MISSING) {
            missing++;
        }
        recoveries = twi_recoveries;
        idle_sleep();
    }
}

/* SPDX-License-Identifier: MIT */
#include "command.h"
#include "health.h"
#include "hx711.h"
#include "idle.h"
#include "lamp.h"
#include "setup.h"
#include "store.h"
#include "telemetry.h"
#include "thermometer.h"
#include "ticks.h"
#include "uart.h"
#include "watchdog.h"
#include "weighing.h"

#include <stdbool.h>
#include <stdint.h>

/* In 2^16 us. */
enum {
    THERMOMETER       = 15, /* 0.98 s */
    FIRST_TEMPERATURE = 1   /* the part must wake, then measure */
};

/* Not more than the buffer holds: a host that never stops must not keep the converter waiting. */
static void receive(void)
{
    uint8_t byte;

    for (uint8_t left = UART_RX_LEN; left != 0U && uart_read(&byte); left--) {
        command_receive(byte);
    }
}

static void weigh(void)
{
    hx711_conversion_t   conversion = {0};
    messages_sample_t    sample;
    const hx711_status_t status = hx711_poll(&conversion);

    if (status != HX711_NOTHING && weighing_take(&sample, status, &conversion)) {
        telemetry_sample(&sample, conversion.device_us);
    }
}

static void measure_temperature(uint32_t now_us)
{
    static uint8_t asked;
    const uint8_t  now = (uint8_t)(now_us >> 16);
    int16_t        centi;

    if ((uint8_t)(now - asked) >=
        (weighing_awaits_temperature() ? FIRST_TEMPERATURE : THERMOMETER)) {
        asked = now;
        thermometer_ask(now_us);
    }
    switch (thermometer_poll(&centi, now_us)) {
    case THERMOMETER_READING: weighing_temperature(centi); break;
    case THERMOMETER_MISSING: weighing_no_temperature(); break;
    case THERMOMETER_NOTHING:
    default: break;
    }
}

/* It never returns: there is nothing to save for who called it. */
int main(void) __attribute__((OS_main));

int main(void)
{
    lamp_init();
    ticks_init();
    uart_init();
    setup_init();
    command_init();
    telemetry_init();
    thermometer_init();
    idle_init();
    hx711_init((hx711_gain_t)setup.gain);
    watchdog_start();
    telemetry_hello();

    for (;;) {
        watchdog_feed();
        idle_clear_work();
        receive();
        weigh();
        const uint32_t now_us = ticks_device_us();
        measure_temperature(now_us);
        store_tick(&setup);
        telemetry_tick(now_us);
        lamp_update(health_faults(), now_us);
        idle_sleep();
    }
}

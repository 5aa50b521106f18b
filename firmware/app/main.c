/* SPDX-License-Identifier: MIT */
#include "command.h"
#include "hx711.h"
#include "idle.h"
#include "led.h"
#include "telemetry.h"
#include "ticks.h"
#include "uart.h"
#include "watchdog.h"
#include "weighing.h"

#include <stdbool.h>
#include <stdint.h>

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
    hx711_conversion_t conversion;
    hx711_status_t     status = hx711_poll(&conversion);

    if (status == HX711_NOTHING) { return; }
    if (status > HX711_DROPPED) { /* there was no conversion */
        weighing_lose_beat();
    } else if (!weighing_time(conversion.device_us)) {
        hx711_distrust();
        status = HX711_DROPPED;
    }
    if (hx711_state() != HX711_STATE_RUNNING) { weighing_restart(); }
    if (status == HX711_CONVERSION) {
        messages_sample_t sample;
        weighing_update(&sample, &conversion);
        telemetry_sample(&sample, conversion.device_us);
    }
}

int main(void)
{
    led_init();
    ticks_init();
    uart_init();
    weighing_init();
    command_init();
    telemetry_init();
    idle_init();
    hx711_init(HX711_GAIN_128);
    watchdog_start();
    telemetry_hello();

    for (;;) {
        watchdog_feed();
        idle_clear_work();
        receive();
        weigh();
        telemetry_tick(ticks_device_us());
        idle_sleep();
    }
}

/* SPDX-License-Identifier: MIT */
#include "attitude.h"
#include "command.h"
#include "health.h"
#include "hx711.h"
#include "idle.h"
#include "lamp.h"
#include "led.h"
#include "mpu6050.h"
#include "setup.h"
#include "store.h"
#include "telemetry.h"
#include "ticks.h"
#include "uart.h"
#include "watchdog.h"
#include "weighing.h"

#include <stdbool.h>
#include <stdint.h>

/* In 2^16 us. */
enum {
    TEMPERATURE       = 15, /* 0.98 s */
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
    static uint8_t looked;
    const uint8_t  now = (uint8_t)(now_us >> 16);
    int16_t        centi;

    if ((uint8_t)(now - looked) <
        (weighing_awaits_temperature() ? FIRST_TEMPERATURE : TEMPERATURE)) {
        return;
    }
    looked = now;
    if (attitude_temperature(&centi)) {
        weighing_temperature(centi);
    } else if (mpu6050_state() == MPU6050_ABSENT) {
        weighing_no_temperature();
    }
}

static void show(uint32_t now_us)
{
    const uint16_t faults = health_faults();

    if (setup.imu_lamp != 0U && faults == 0U) {
        led_set(attitude_is_still());
    } else {
        lamp_update(faults, now_us);
    }
}

/* It never returns: there is nothing to save for who called it. */
int main(void) __attribute__((OS_main));

int main(void)
{
    lamp_init();
    ticks_init();
    setup_init();
    uart_init((uart_baud_t)setup.uart_baud);
    command_init();
    telemetry_init();
    idle_init();
    hx711_init((hx711_gain_t)setup.gain);
    watchdog_start();
    telemetry_hello();

    for (;;) {
        watchdog_feed();
        idle_clear_work();
        receive();
        attitude_poll();
        weigh();
        attitude_poll();
        const uint32_t now_us = ticks_device_us();
        measure_temperature(now_us);
        store_tick(&setup);
        telemetry_tick(now_us);
        show(now_us);
        idle_sleep();
    }
}

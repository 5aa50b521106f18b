/* SPDX-License-Identifier: MIT */
#include "hx711.h"

#include "idle.h"
#include "ticks.h"
#include "uno_pins.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/delay.h>

enum { SETTLING_CONVERSIONS = 4 }; /* HX711 datasheet p. 3: 50 ms at 80 SPS, 400 ms at 10 */

/* Above 60 us PD_SCK high powers the chip down, HX711 datasheet p. 5; between 50 and 60 nothing is
 * said. Longer does no harm. */
#define POWER_DOWN_US 80.0

/* The slowest conversion: 1105920 clocks of a chip somewhat slower than nominal, 100 ms, twice and
 * a half. After a restart the first one may come only after the settling time, 400 ms. */
#define TIMEOUT_US       250000UL
#define TIMEOUT_FIRST_US 600000UL

/* The fastest conversion: 138240 clocks at 20 MHz, HX711 datasheet p. 2. */
#define PERIOD_MIN_US 6912UL

static volatile bool     edge_seen; /* INT0 writes, main loop clears while INT0 is masked */
static volatile uint32_t edge_us;   /* INT0 writes, main loop reads while INT0 is masked */

static hx711_gain_t     extra_pulses;
static hx711_state_t    state;
static hx711_counters_t counters;
static uint8_t          settling_left; /* conversions still to drop */
static uint32_t         waiting_since_us;
static uint32_t         timeout_us;
static uint32_t         fresh_us; /* a read that ends later than this is late */

ISR(HX711_vect)
{
    edge_us = ticks_device_us_in_isr();
    idle_interrupted();
    edge_seen = true;
    EIMSK &= (uint8_t)~_BV(INT0); /* the bits of the frame make edges too */
    idle_post_work();
}

static void count(uint16_t *counter)
{
    if (*counter != UINT16_MAX) { (*counter)++; }
}

static void settle(void)
{
    settling_left = SETTLING_CONVERSIONS;
    if (extra_pulses != HX711_GAIN_128) { settling_left++; } /* the first read sets the gain */
}

/* Power the chip down and up, as the only way to know where it stands. The edge is armed but the
 * level is not looked at: a DOUT stuck low must run into the time-out, not be read again and
 * again. */
static void restart(hx711_state_t why)
{
    EIMSK &= (uint8_t)~_BV(INT0);
    edge_seen = false;
    HX711_PORT |= _BV(HX711_PD_SCK);
    _delay_us(POWER_DOWN_US);
    HX711_PORT &= (uint8_t)~_BV(HX711_PD_SCK);
    EIFR = _BV(INTF0);
    EIMSK |= _BV(INT0);

    state            = why;
    waiting_since_us = ticks_device_us();
    timeout_us       = TIMEOUT_FIRST_US;
    settle();
}

/* After a frame, INT0 still masked: forget the edges that its bits made, then look at the level.
 * Low means that a conversion came in meanwhile; high, that its edge is still to come. */
static void rearm(void)
{
    EIFR = _BV(INTF0);
    if ((HX711_PIN & _BV(HX711_DOUT)) == 0U) {
        edge_us = ticks_device_us();
        idle_post_work();
    } else {
        edge_seen = false;
        EIMSK |= _BV(INT0);
    }
}

void hx711_init(hx711_gain_t gain)
{
    extra_pulses = gain;
    hx711_set_period_us(PERIOD_MIN_US);

    HX711_PORT |= _BV(HX711_DOUT); /* pull-up, see uno_pins.h */
    HX711_PORT &= (uint8_t)~_BV(HX711_PD_SCK);
    HX711_DDR |= _BV(HX711_PD_SCK);
    EICRA = _BV(ISC01); /* falling edge */
    restart(HX711_STATE_SETTLING);
}

static hx711_status_t judge(bool intact, uint32_t age_us)
{
    if (!intact) {
        count(&counters.bad_frames);
        restart(HX711_STATE_BAD_FRAME);
        return HX711_BAD_FRAME;
    }
    if (counters.conversions != UINT32_MAX) { counters.conversions++; }
    timeout_us = TIMEOUT_US;
    rearm();

    if (age_us > fresh_us) { settle(); }
    if (settling_left != 0U) {
        settling_left--;
        state = HX711_STATE_SETTLING;
        count(&counters.settling_dropped);
        return HX711_DROPPED;
    }
    state = HX711_STATE_RUNNING;
    return HX711_CONVERSION;
}

hx711_status_t hx711_poll(hx711_conversion_t *conversion)
{
    if (!edge_seen) {
        if (ticks_device_us() - waiting_since_us < timeout_us) { return HX711_NOTHING; }
        count(&counters.timeouts);
        restart(HX711_STATE_TIMED_OUT);
        return HX711_TIMED_OUT;
    }

    conversion->device_us = edge_us;
    if ((HX711_PIN & _BV(HX711_DOUT)) != 0U) { /* a spike on the line: the chip is at work */
        count(&counters.bad_frames);
        rearm();
        return HX711_NOTHING;
    }
    const bool     intact = hx711_read(&conversion->counts, extra_pulses);
    const uint32_t now_us = ticks_device_us();

    waiting_since_us = now_us;
    return judge(intact, now_us - conversion->device_us);
}

void hx711_set_period_us(uint32_t period_us)
{
    if (period_us < PERIOD_MIN_US) { period_us = PERIOD_MIN_US; }
    fresh_us = period_us - (period_us >> 6);
}

void hx711_distrust(void)
{
    if (state == HX711_STATE_RUNNING) { count(&counters.settling_dropped); }
    state = HX711_STATE_SETTLING;
    settle();
    settling_left--; /* that one */
}

hx711_state_t hx711_state(void)
{
    return state;
}

uint8_t hx711_gain(void)
{
    switch (extra_pulses) {
    case HX711_GAIN_32: return 32;
    case HX711_GAIN_64: return 64;
    case HX711_GAIN_128:
    default: return 128;
    }
}

const hx711_counters_t *hx711_counters(void)
{
    return &counters;
}

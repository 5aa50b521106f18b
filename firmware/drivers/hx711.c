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

/* Time-outs are reckoned in 16 bits of 2^10 us, which wrap after 67 s. */
#define COARSE_SHIFT 10

/* While no interval is known: 2.4 times 100 ms, the slowest conversion, for a clock that is slow by
 * a tenth. After a restart the first one may come only after the settling time, 400 ms. */
#define TIMEOUT       (240000UL >> COARSE_SHIFT)
#define TIMEOUT_FIRST (600000UL >> COARSE_SHIFT)

/* DOUT is low for no longer than a conversion waits to be read, and high after a restart. */
#define TIMEOUT_LOW (120000UL >> COARSE_SHIFT)

/* The fastest conversion: 138240 clocks at 20 MHz, HX711 datasheet p. 2. */
#define PERIOD_MIN_US 6912UL

static volatile bool     edge_seen; /* INT0 writes, main loop clears while INT0 is masked */
static volatile uint32_t edge_us;   /* INT0 writes, main loop reads while INT0 is masked */

static hx711_gain_t     extra_pulses;
static hx711_state_t    state;
static hx711_counters_t counters;
static uint8_t          settling_left; /* conversions still to drop */
static bool             has_edge;      /* read_edge is of this run */
static uint16_t         read_edge;     /* when DOUT fell for the conversion read last; coarse */
static uint16_t         waiting_since; /* coarse */
static uint16_t         timeout;       /* coarse */
static uint32_t         period_us;     /* as told, >= PERIOD_MIN_US */

ISR(HX711_vect)
{
    edge_us = ticks_device_us_in_isr();
    idle_interrupted();
    edge_seen = true;
    EIMSK &= (uint8_t)~_BV(INT0); /* the bits of the frame make edges too */
    idle_post_work();
}

static uint16_t coarse(uint32_t us)
{
    return (uint16_t)(us >> COARSE_SHIFT);
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

static bool is_dout_low(void)
{
    return (HX711_PIN & _BV(HX711_DOUT)) == 0U;
}

/* Power the chip down and up, as the only way to know where it stands. The edge is armed but the
 * level is not looked at: a DOUT stuck low must run into the time-out, not be read again and
 * again. Gives HX711_STUCK_LOW where DOUT is low all along, for a chip at work lets it go high,
 * else what was asked. */
static hx711_status_t restart(hx711_state_t why, hx711_status_t status)
{
    EIMSK &= (uint8_t)~_BV(INT0);
    edge_seen = false;
    HX711_PORT |= _BV(HX711_PD_SCK);
    _delay_us(POWER_DOWN_US);
    bool is_low = is_dout_low();
    HX711_PORT &= (uint8_t)~_BV(HX711_PD_SCK);
    EIFR = _BV(INTF0);
    EIMSK |= _BV(INT0);

    state         = why;
    has_edge      = false;
    waiting_since = coarse(ticks_device_us());
    timeout       = TIMEOUT_FIRST;
    settle();
    is_low = is_low && is_dout_low();
    return is_low ? HX711_STUCK_LOW : status;
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
    restart(HX711_STATE_SETTLING, HX711_NOTHING);
}

/* A period and a quarter of patience beyond what the converter has shown to need. */
static void expect(uint16_t edge)
{
    uint16_t wait = TIMEOUT;

    if (has_edge) {
        const uint16_t period = coarse(period_us);
        wait                  = (uint16_t)(edge - read_edge);
        if (wait < period) { wait = period; }
        wait = (uint16_t)(wait * 2U + (wait >> 2) + 1U); /* < 2^16: no edge waits for 29 s */
        if (wait > TIMEOUT) { wait = TIMEOUT; }
    }
    has_edge  = true;
    read_edge = edge;
    timeout   = wait;
}

static hx711_status_t judge(bool intact, uint32_t age_us)
{
    if (!intact) {
        count(&counters.bad_frames);
        return restart(HX711_STATE_BAD_FRAME, HX711_BAD_FRAME);
    }
    if (counters.conversions != UINT32_MAX) { counters.conversions++; }
    rearm();

    if (age_us > period_us - (period_us >> 6)) { settle(); }
    if (settling_left != 0U) {
        settling_left--;
        state = HX711_STATE_SETTLING;
        count(&counters.settling_dropped);
        return HX711_DROPPED;
    }
    state = HX711_STATE_RUNNING;
    return HX711_CONVERSION;
}

/* Nothing to read: for how long already? The level is looked at before the flag, so that an edge
 * in between is no level that lasts. */
static hx711_status_t wait(bool is_low, uint16_t now)
{
    const uint16_t most = is_low && timeout > TIMEOUT_LOW ? TIMEOUT_LOW : timeout;

    if ((uint16_t)(now - waiting_since) < most) { return HX711_NOTHING; }
    count(&counters.timeouts);
    hx711_set_period_us(0);
    return restart(HX711_STATE_TIMED_OUT, is_low ? HX711_STUCK_LOW : HX711_TIMED_OUT);
}

hx711_status_t hx711_poll(hx711_conversion_t *conversion)
{
    const bool is_low = is_dout_low();

    if (!edge_seen) { return wait(is_low, coarse(ticks_device_us())); }

    conversion->device_us = edge_us;
    if (!is_dout_low()) { /* a spike on the line: the chip is at work */
        count(&counters.bad_frames);
        rearm();
        return HX711_NOTHING;
    }
    const bool     intact = hx711_read(&conversion->counts, extra_pulses);
    const uint32_t now_us = ticks_device_us();

    expect(coarse(conversion->device_us));
    waiting_since = coarse(now_us);
    return judge(intact, now_us - conversion->device_us);
}

void hx711_set_gain(hx711_gain_t gain)
{
    if (gain == extra_pulses) { return; }
    extra_pulses  = gain;
    settling_left = SETTLING_CONVERSIONS + 1; /* the next one is still of the old gain */
    if (state == HX711_STATE_RUNNING) { state = HX711_STATE_SETTLING; }
}

void hx711_set_period_us(uint32_t told_us)
{
    period_us = told_us < PERIOD_MIN_US ? PERIOD_MIN_US : told_us;
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

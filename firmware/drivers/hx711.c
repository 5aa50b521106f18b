/* SPDX-License-Identifier: MIT */
#include "hx711.h"

#include "idle.h"
#include "port_clamp.h"
#include "port_outline.h"
#include "port_reach.h"
#include "ticks.h"
#include "uno_pins.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/delay.h>

enum { SETTLING_CONVERSIONS = 4 }; /* HX711 datasheet p. 3: 50 ms at 80 SPS, 400 ms at 10 */

/* Above 60 us PD_SCK high powers the chip down, HX711 datasheet p. 5; between 50 and 60 nothing is
 * said. Longer does no harm. */
#define POWER_DOWN_US 80.0

/* Times are reckoned in 16 bits of 2^6 us, which wrap after 4 s: the watchdog's half second is the
 * longest that nobody looks. */
#define COARSE_SHIFT 6

/* While no interval is known: 2.4 times 100 ms, the slowest conversion, for a clock that is slow by
 * a tenth. After a restart the first one may come only after the settling time, 400 ms. */
#define TIMEOUT       (240000UL >> COARSE_SHIFT)
#define TIMEOUT_FIRST (600000UL >> COARSE_SHIFT)

/* DOUT is low for no longer than a conversion waits to be read, and high after a restart. */
#define TIMEOUT_LOW (120000UL >> COARSE_SHIFT)

/* The fastest conversion: 138240 clocks at 20 MHz, HX711 datasheet p. 2. */
#define PERIOD_MIN (6912UL >> COARSE_SHIFT)

static volatile bool     edge_seen; /* INT0 writes, main loop clears while INT0 is masked */
static volatile uint32_t edge_us;   /* INT0 writes, main loop reads while INT0 is masked */

typedef struct {
    hx711_counters_t counters;
    uint16_t         latest;    /* a read that ends longer than this after its edge is late */
    uint16_t         read_edge; /* when DOUT fell for the conversion read last */
    uint16_t         waiting_since;
    uint16_t         timeout;
    hx711_gain_t     extra_pulses;
    hx711_state_t    state;
    uint8_t          settling_left; /* conversions still to drop */
    bool             has_edge;      /* read_edge is of this run */
} chip_t;

static chip_t chip;

ISR(HX711_vect)
{
    edge_us = ticks_device_us_in_isr();
    idle_interrupted();
    edge_seen = true;
    EIMSK &= (uint8_t)~_BV(INT0); /* the bits of the frame make edges too */
    idle_post_work();
}

static PORT_OUTLINE uint16_t coarse(uint32_t us)
{
    return (uint16_t)(us >> COARSE_SHIFT);
}

static PORT_OUTLINE void settle(chip_t *it)
{
    it->settling_left = SETTLING_CONVERSIONS;
    if (it->extra_pulses != HX711_GAIN_128) { it->settling_left++; } /* the first sets the gain */
}

static bool is_dout_low(void)
{
    return (HX711_PIN & _BV(HX711_DOUT)) == 0U;
}

/* Power the chip down and up, as the only way to know where it stands. The edge is armed but the
 * level is not looked at: a DOUT stuck low must run into the time-out, not be read again and
 * again. Gives HX711_STUCK_LOW where DOUT is low all along, for a chip at work lets it go high,
 * else what was asked. */
static hx711_status_t restart(chip_t *it, hx711_state_t why, hx711_status_t status)
{
    EIMSK &= (uint8_t)~_BV(INT0);
    edge_seen = false;
    HX711_PORT |= _BV(HX711_PD_SCK);
    _delay_us(POWER_DOWN_US);
    const bool is_low = is_dout_low();
    HX711_PORT &= (uint8_t)~_BV(HX711_PD_SCK);
    EIFR = _BV(INTF0);
    EIMSK |= _BV(INT0);

    it->state         = why;
    it->has_edge      = false;
    it->waiting_since = coarse(ticks_device_us());
    it->timeout       = TIMEOUT_FIRST;
    settle(it);
    return is_low && is_dout_low() ? HX711_STUCK_LOW : status;
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
    chip_t *const it = PORT_REACH(&chip);

    it->extra_pulses = gain;
    hx711_set_period_8us(0);

    HX711_PORT |= _BV(HX711_DOUT); /* pull-up, see uno_pins.h */
    HX711_PORT &= (uint8_t)~_BV(HX711_PD_SCK);
    HX711_DDR |= _BV(HX711_PD_SCK);
    EICRA = _BV(ISC01); /* falling edge */
    restart(it, HX711_STATE_SETTLING, HX711_NOTHING);
}

/* A period and a quarter of patience beyond what the converter has shown to need. */
static void expect(chip_t *it, uint16_t edge)
{
    uint16_t wait = TIMEOUT;

    if (it->has_edge) {
        wait = (uint16_t)(edge - it->read_edge);
        if (wait < it->latest) { wait = it->latest; }
        wait = (uint16_t)(wait * 2U + (wait >> 2) + 1U); /* < 2^16: no edge waits for 1.8 s */
        if (wait > TIMEOUT) { wait = TIMEOUT; }
    }
    it->has_edge  = true;
    it->read_edge = edge;
    it->timeout   = wait;
}

static hx711_status_t judge(chip_t *it, bool intact, uint16_t age)
{
    if (!intact) {
        port_count(&it->counters.bad_frames);
        return restart(it, HX711_STATE_BAD_FRAME, HX711_BAD_FRAME);
    }
    if (it->counters.conversions != UINT32_MAX) { it->counters.conversions++; }
    rearm();

    if (age > it->latest) { settle(it); }
    if (it->settling_left != 0U) {
        it->settling_left--;
        it->state = HX711_STATE_SETTLING;
        port_count(&it->counters.settling_dropped);
        return HX711_DROPPED;
    }
    it->state = HX711_STATE_RUNNING;
    return HX711_CONVERSION;
}

/* Nothing to read: for how long already? The level is looked at before the flag, so that an edge
 * in between is no level that lasts. */
static hx711_status_t wait(chip_t *it, bool is_low)
{
    uint16_t most = it->timeout;

    if (is_low && most > TIMEOUT_LOW) { most = TIMEOUT_LOW; }
    if ((uint16_t)(coarse(ticks_device_us()) - it->waiting_since) < most) { return HX711_NOTHING; }
    port_count(&it->counters.timeouts);
    hx711_set_period_8us(0);
    return restart(it, HX711_STATE_TIMED_OUT, is_low ? HX711_STUCK_LOW : HX711_TIMED_OUT);
}

hx711_status_t hx711_poll(hx711_conversion_t *conversion)
{
    chip_t *const it     = PORT_REACH(&chip);
    const bool    is_low = is_dout_low();

    if (!edge_seen) { return wait(it, is_low); }

    conversion->device_us = edge_us;
    if (!is_dout_low()) { /* a spike on the line: the chip is at work */
        port_count(&it->counters.bad_frames);
        rearm();
        return HX711_NOTHING;
    }
    const bool     intact = hx711_read(&conversion->counts, it->extra_pulses);
    const uint16_t now    = coarse(ticks_device_us());
    const uint16_t edge   = coarse(conversion->device_us);

    expect(it, edge);
    it->waiting_since = now;
    return judge(it, intact, (uint16_t)(now - edge));
}

void hx711_set_gain(hx711_gain_t gain)
{
    chip_t *const it = PORT_REACH(&chip);

    if (gain == it->extra_pulses) { return; }
    it->extra_pulses  = gain;
    it->settling_left = SETTLING_CONVERSIONS + 1; /* the next one is still of the old gain */
    if (it->state == HX711_STATE_RUNNING) { it->state = HX711_STATE_SETTLING; }
}

PORT_OUTLINE void hx711_set_period_8us(uint16_t period_8us)
{
    uint16_t period = period_8us >> (COARSE_SHIFT - 3);

    if (period < PERIOD_MIN) { period = PERIOD_MIN; }
    chip.latest = (uint16_t)(period - (period >> 6));
}

void hx711_distrust(void)
{
    chip_t *const it = PORT_REACH(&chip);

    if (it->state == HX711_STATE_RUNNING) { port_count(&it->counters.settling_dropped); }
    it->state = HX711_STATE_SETTLING;
    settle(it);
    it->settling_left--; /* that one */
}

hx711_state_t hx711_state(void)
{
    return chip.state;
}

PORT_OUTLINE uint8_t hx711_gain(void)
{
    switch (chip.extra_pulses) {
    case HX711_GAIN_32: return 32;
    case HX711_GAIN_64: return 64;
    case HX711_GAIN_128:
    default: return 128;
    }
}

const hx711_counters_t *hx711_counters(void)
{
    return &chip.counters;
}

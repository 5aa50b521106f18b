/* SPDX-License-Identifier: MIT */
/* hx711 - driver of the load-cell converter HX711: raw counts, time of conversion, health.
 *
 * Model     DOUT falls when a conversion is done; 24 pulses on PD_SCK bring its bits, the 25th
 *           (26th, 27th) sets the next gain and DOUT rests high (HX711 datasheet, p. 4-5).
 *           Interrupts are off only while PD_SCK is high, because a pulse beyond 50 us may power
 *           the chip down.
 * Formats   counts: 24 bits two's complement in int32    device_us: when DOUT fell, noted by INT0
 * Settling  4 conversions after power-up, a restart or a change of gain are read and dropped, and
 *           before a change of gain the one that the chip has still made with the old gain
 * Time-out  2 1/4 times the last interval, or the period if that is longer; 240 ms while there is
 *           neither; 600 ms after a restart. It is looked at in hx711_poll.
 * Bad data  DOUT low where it must rest high: bad frame, the chip is restarted
 *           DOUT low for longer than any conversion takes, or through a restart: stuck low; the
 *           chip is restarted every 120 ms
 *           a falling edge without a conversion behind it: counted as a bad frame, nothing read
 *           no conversion within the time-out: the chip is restarted, again and again
 *           read too late, into the next conversion: settles anew, for that one, the next (stray
 *           bits) and the one after it (a gain set by the strays) are spoilt
 *           a lost clock pulse shows only where the last bit is 0, as DOUT then does not rise
 * Context   main loop, interrupts on; INT0 is the driver's own.  Cost: firmware/budget.toml
 */
#ifndef HX711_H
#define HX711_H

#include <stdbool.h>
#include <stdint.h>

/* Pulses behind the 24 of the bits. */
typedef enum {
    HX711_GAIN_128 = 1, /* channel A */
    HX711_GAIN_32  = 2, /* channel B */
    HX711_GAIN_64  = 3  /* channel A */
} hx711_gain_t;

typedef enum {
    HX711_NOTHING,    /* the converter is at work, whatever noise the line makes */
    HX711_CONVERSION, /* the out-parameter is filled */
    HX711_DROPPED,    /* settling: its time is good, its counts are not */
    HX711_BAD_FRAME,  /* refused; after a restart the converter settles */
    HX711_TIMED_OUT,  /* nothing came, DOUT is high; the converter was restarted */
    HX711_STUCK_LOW   /* DOUT stays low; the converter was restarted */
} hx711_status_t;

/* As the latest event left it. */
typedef enum {
    HX711_STATE_SETTLING,
    HX711_STATE_RUNNING,
    HX711_STATE_TIMED_OUT,
    HX711_STATE_BAD_FRAME
} hx711_state_t;

typedef struct {
    int32_t  counts;    /* -2^23 .. 2^23 - 1 */
    uint32_t device_us; /* when DOUT fell */
} hx711_conversion_t;

/* Since reset; each stops at its maximum. */
typedef struct {
    uint32_t conversions; /* frames clocked out whole, dropped ones included */
    uint16_t settling_dropped;
    uint16_t timeouts;
    uint16_t bad_frames;
} hx711_counters_t;

/* Take the lines, restart the chip (81 us), wait for conversions. */
void hx711_init(hx711_gain_t gain);

/* Read the conversion that is ready, if one is. */
hx711_status_t hx711_poll(hx711_conversion_t *conversion);

/* Another gain or channel: what comes next is of the new one. The chip takes 4 conversions to
 * settle; with the one under way, 5 are dropped. */
void hx711_set_gain(hx711_gain_t gain);

/* Tell the period between conversions once it is known: a read that ends later than this after
 * DOUT fell has run into the next conversion. While it is 0, not known, the shortest possible one
 * holds; so it does after a time-out, for the converter may have another rate since. */
void hx711_set_period_8us(uint16_t period_8us);

/* The conversion just given came at a time that no conversion was due: the chip has started anew
 * without being told to, as after a loose contact. It and those after it settle. */
void hx711_distrust(void);

hx711_state_t hx711_state(void);
uint8_t       hx711_gain(void); /* 128, 64 or 32 */

const hx711_counters_t *hx711_counters(void);

/* Clock one frame out of a chip whose DOUT is low; false: DOUT did not rest high behind it.
 * Interrupts must be on; they are off for at most 10 cycles at a time. For hx711_poll and for the
 * measurement of its cost. */
bool hx711_read(int32_t *counts, uint8_t extra_pulses);

#endif

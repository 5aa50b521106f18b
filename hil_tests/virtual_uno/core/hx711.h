/* SPDX-License-Identifier: GPL-3.0-or-later */
/* hx711 - the load-cell converter as its two wires show it.
 *
 * Model     Avia HX711 datasheet V2.0, pp. 4..6. DOUT falls when a conversion is ready; pulse n
 *           (1..24) puts out bit 24-n within T2 = 0.1 us; DOUT is high from pulse 25 on. 25, 26
 *           or 27 pulses choose A/128, B/32, A/64 for the next conversion; a change of gain, a
 *           start and power-down make the next four conversions wrong (settling)
 * Knows not the board: time is ticks of the caller's choice, outputs are callbacks
 * Bad use   a conversion that completes within a frame takes over the shift register, so that
 *           frame is a mixture and the pulses left over count towards the next; more than 27
 *           pulses leave gain 64 behind. Everything is counted
 * Context   not thread-safe; callbacks must not call back into the same instance
 */
#ifndef HX711_H
#define HX711_H

#include <stdbool.h>
#include <stdint.h>

#include "uno.h"

enum {
    HX711_FLOATS     = 2, /* line level given when nothing drives DOUT */
    HX711_SETTLING   = 4, /* conversions, datasheet p. 3 */
    HX711_SCHEDULED  = 64,
    HX711_COUNTS_MAX = 0x7FFFFF,
    HX711_COUNTS_MIN = -0x800000,
};

typedef void (*hx711_dout_fn)(void *ctx, uint64_t tick, uint8_t level);
typedef void (*hx711_source_fn)(void *ctx, const uint64_t *ticks, double *counts, uint32_t n);

typedef struct {
    uint64_t ticks[HX711_SCHEDULED];  /* instants of the coming conversions */
    double   values[HX711_SCHEDULED]; /* the signal there */
    uint32_t next, count;
    bool     valued; /* values were asked for */
    double   grid;   /* exact instant of the conversion after the last one */
} hx711_schedule_t;

struct hx711 {
    hx711_config_t config;
    double         hz; /* ticks a second */
    struct {           /* datasheet times in ticks, rounded to the strict side */
        uint64_t t1, t2, t3_min, t3_max, t4_min, power_down;
    } limit;

    hx711_dout_fn    dout_moved;
    hx711_source_fn  source;
    void            *ctx;
    bool             constant;
    double           constant_counts;
    hx711_schedule_t schedule;
    uint64_t         noise_state, jitter_state, flip_state;

    bool     powered_down;
    uint8_t  sck;
    uint64_t sck_rose, sck_fell;
    uint8_t  dout; /* the part's own level */
    uint8_t  line; /* as last told: 0, 1 or HX711_FLOATS */
    uint64_t dout_fell, line_moved;
    uint8_t  pending_level; /* what DOUT becomes ... */
    uint64_t pending_tick;  /* ... then; UINT64_MAX: nothing pending */

    bool     ready;      /* a conversion is in the register */
    uint8_t  pulses;     /* since it came, 255 = 255 or more */
    bool     losing;     /* a fault will swallow one pulse of this frame */
    bool     stretching; /* or stretch one */
    uint32_t shift;      /* bits not yet out, left-aligned in 24 */
    uint8_t  gain;       /* of the conversions now running */
    uint8_t  settling_left;
    double   settled_from; /* where a settling sequence started */

    hx711_fault_t   fault;
    hx711_stats_t   stats;
    hx711_record_t *records;
    uint32_t        record_count, record_room;
};

void hx711_connect(hx711_t *hx, hx711_dout_fn dout_moved, hx711_source_fn source, void *ctx);
void hx711_power_on(hx711_t *hx, uint64_t tick);
void hx711_set_source(hx711_t *hx);
void hx711_set_fault(hx711_t *hx, uint64_t tick, const hx711_fault_t *fault);
void hx711_get_fault(const hx711_t *hx, hx711_fault_t *fault);
/* Tells the line's level again and forgets signal values asked for ahead. */
void hx711_restate(hx711_t *hx);
/* Conversions a second, faults reckoned in. */
double hx711_rate_hz(const hx711_t *hx);
/* When hx711_advance() has something to do next. */
uint64_t hx711_next_tick(const hx711_t *hx);

/* --- hx711_signal.c: what a conversion yields, and when --- */
/* Plans the coming conversions, the first at `first_tick`. */
void     hx711_schedule_from(hx711_t *hx, double first_tick);
uint64_t hx711_scheduled_tick(const hx711_t *hx);
/* Takes the conversion due now off the schedule: the signal, without noise and faults. */
double  hx711_take_value(hx711_t *hx);
int32_t hx711_quantise(hx711_t *hx, double value);
double  hx711_random_normal(uint64_t *state);
double  hx711_random_unit(uint64_t *state);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "hx711.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FRAME_BITS = 24, FRAME_PULSES = 25, FRAME_PULSES_MAX = 27, FIRST_ROOM = 1024 };

#define NEVER UINT64_MAX

/* Errors of the four settling conversions, as parts of the way from where they started. */
static const double settling_error[HX711_SETTLING] = {0.50, 0.12, 0.03, 0.01};

/* A start begins a quarter of the range away, so that no settling sample can pass for good. */
static const double start_offset_counts = 2097152.0;

/* --- the line --- */

static uint8_t line_level(const hx711_t *hx)
{
    if (hx->fault.cable_out) { return HX711_FLOATS; }
    if (hx->fault.dout_stuck_high) { return 1; }
    if (hx->fault.dout_stuck_low) { return 0; }
    return hx->dout;
}

static void tell(hx711_t *hx, uint64_t tick)
{
    const uint8_t level = line_level(hx);

    if (level == hx->line) { return; }
    hx->line       = level;
    hx->line_moved = tick;
    if (hx->dout_moved) { hx->dout_moved(hx->ctx, tick, level); }
}

static void set_dout(hx711_t *hx, uint64_t tick, uint8_t level)
{
    if (hx->dout && !level) { hx->dout_fell = tick; }
    hx->dout = level;
    tell(hx, tick);
}

/* --- conversions --- */

static hx711_record_t *last_record(hx711_t *hx)
{
    return hx->record_count ? &hx->records[hx->record_count - 1U] : NULL;
}

static void record(hx711_t *hx, const hx711_record_t *entry)
{
    if (hx->record_count == hx->record_room) {
        const uint32_t  room    = hx->record_room ? 2U * hx->record_room : FIRST_ROOM;
        hx711_record_t *records = realloc(hx->records, room * sizeof *records);

        if (!records) { return; } /* the truth ends here; the part goes on */
        hx->records     = records;
        hx->record_room = room;
    }
    hx->records[hx->record_count++] = *entry;
}

static void settle_from(hx711_t *hx, double counts)
{
    hx->settled_from  = counts;
    hx->settling_left = HX711_SETTLING;
}

/* The frame that the next conversion ends: its verdict, and the gain that it asked for. */
static void close_frame(hx711_t *hx, uint64_t tick)
{
    hx711_record_t *entry = last_record(hx);
    const uint8_t   n     = hx->pulses;

    if (!hx->ready || !entry) { return; }
    entry->pulses = n;
    if (n == 0) {
        hx->stats.conversions_missed++;
        return;
    }
    if (n < FRAME_PULSES) {
        hx->stats.frames_short++;
        if (tick - hx->sck_rose < hx->limit.power_down) { hx->stats.overruns++; }
        return;
    }
    if (n > FRAME_PULSES_MAX) { hx->stats.frames_long++; }
    hx->stats.frames_read++;
    entry->read = 1;

    const uint8_t gain = n == FRAME_PULSES ? 128 : n == FRAME_PULSES + 1 ? 32 : 64;
    if (gain != hx->gain) {
        settle_from(hx, entry->source * hx->gain / gain); /* the old channel's, rescaled */
        hx->gain = gain;
        if (fabs(hx->settled_from - entry->source) < start_offset_counts / 8) {
            hx->settled_from += start_offset_counts;
        }
    }
}

static void convert(hx711_t *hx, uint64_t tick)
{
    const double source = hx711_take_value(hx);
    double       value  = source;

    if (hx->fault.lost_conversions) {
        hx->fault.lost_conversions--;
        return;
    }
    close_frame(hx, tick);
    hx711_record_t entry = {.tick = tick, .source = source, .gain = hx->gain};

    if (hx->settling_left) {
        const uint8_t i = (uint8_t)(HX711_SETTLING - hx->settling_left);
        value += (hx->settled_from - value) * settling_error[i];
        entry.settling = 1;
        hx->settling_left--;
    }
    const hx711_record_t *last = last_record(hx);
    entry.counts = hx->fault.frozen && last ? last->counts : hx711_quantise(hx, value);
    hx->shift    = (uint32_t)entry.counts & 0xFFFFFFU;
    hx->pulses   = 0;
    hx->ready    = true;
    hx->stats.conversions++;
    record(hx, &entry);
    hx->losing = hx->fault.lost_pulse_frames > 0;
    if (hx->losing) { hx->fault.lost_pulse_frames--; }
    hx->stretching = hx->fault.stretched_frames > 0;
    if (hx->stretching) { hx->fault.stretched_frames--; }
    hx->pending_tick = NEVER;
    if (hx->config.update_pulse_s > 0.0 && !hx->dout) { set_dout(hx, tick, 1); }
    set_dout(hx, tick, 0);
}

static void restart(hx711_t *hx, uint64_t tick, double first_s)
{
    hx->ready        = false;
    hx->pulses       = 0;
    hx->pending_tick = NEVER;
    settle_from(hx, start_offset_counts);
    hx711_schedule_from(hx, (double)tick + first_s * hx->hz);
    set_dout(hx, tick, 1);
}

static void power_down(hx711_t *hx, uint64_t tick)
{
    /* the pulse that became power-down was no pulse of a frame */
    if (hx->ready && hx->pulses) { hx->pulses--; }
    if (!hx->ready) { hx->stats.busy_pulses--; }
    close_frame(hx, tick);
    hx->powered_down = true;
    hx->ready        = false;
    hx->pulses       = 0;
    hx->pending_tick = NEVER;
    hx->stats.power_downs++;
    if (!hx->config.gain_after_power_down_kept) { hx->gain = 128; }
    set_dout(hx, tick, 1);
}

/* --- time --- */

static bool alive(const hx711_t *hx)
{
    return !hx->powered_down && !hx->fault.cable_out;
}

static uint64_t power_down_tick(const hx711_t *hx)
{
    return hx->sck && alive(hx) ? hx->sck_rose + hx->limit.power_down : NEVER;
}

static uint64_t blink_begin_tick(const hx711_t *hx)
{
    const uint64_t next = hx711_scheduled_tick(hx);
    const uint64_t lead = (uint64_t)(hx->config.update_pulse_s * hx->hz);

    if (!lead || !hx->ready || hx->pulses || hx->dout || next == NEVER) { return NEVER; }
    return next > lead ? next - lead : 0;
}

static uint64_t least(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

uint64_t hx711_next_tick(const hx711_t *hx)
{
    uint64_t next = least(hx->pending_tick, power_down_tick(hx));

    if (alive(hx)) { next = least(next, least(hx711_scheduled_tick(hx), blink_begin_tick(hx))); }
    return next;
}

void hx711_advance(hx711_t *hx, uint64_t tick)
{
    for (;;) {
        const uint64_t due = hx711_next_tick(hx);

        if (due > tick || due == NEVER) { return; }
        if (due == hx->pending_tick) {
            hx->pending_tick = NEVER;
            set_dout(hx, due, hx->pending_level);
        } else if (due == power_down_tick(hx)) {
            power_down(hx, due);
        } else if (due == hx711_scheduled_tick(hx)) {
            convert(hx, due);
        } else {
            set_dout(hx, due, 1);
        }
    }
}

/* --- PD_SCK --- */

static void put_bit(hx711_t *hx, uint64_t tick, uint8_t level)
{
    if (hx->pulses <= FRAME_BITS && hx->fault.flip_probability > 0.0 &&
        hx711_random_unit(&hx->flip_state) < hx->fault.flip_probability) {
        level ^= 1U;
    }
    hx->pending_level = level;
    hx->pending_tick  = tick + hx->limit.t2;
}

static void sck_up(hx711_t *hx, uint64_t tick)
{
    if (hx->ready && hx->pulses) {
        const uint64_t low = tick - hx->sck_fell;
        if (low < hx->stats.sck_low_min_ticks) { hx->stats.sck_low_min_ticks = low; }
        if (low < hx->limit.t4_min) { hx->stats.sck_low_too_short++; }
    }
    hx->sck_rose = tick;
    if (!alive(hx)) { return; }
    if (!hx->ready) {
        hx->stats.busy_pulses++;
        return;
    }
    if (hx->pulses == 0 && tick - hx->dout_fell < hx->limit.t1) { hx->stats.t1_too_short++; }
    if (hx->losing && hx->pulses + 1U == hx->fault.lost_pulse) {
        hx->losing = false;
        return;
    }
    if (hx->pulses < 255U) { hx->pulses++; }
    if (hx->stretching && hx->pulses == hx->fault.stretched_pulse) {
        hx->stretching = false;
        power_down(hx, tick);
        return;
    }
    if (hx->pulses <= FRAME_BITS) {
        put_bit(hx, tick, (uint8_t)((hx->shift >> (FRAME_BITS - hx->pulses)) & 1U));
    } else {
        put_bit(hx, tick, 1);
        if (hx->pulses > FRAME_PULSES_MAX) { hx->stats.busy_pulses++; }
    }
}

static void sck_down(hx711_t *hx, uint64_t tick)
{
    const uint64_t high = tick - hx->sck_rose;

    hx->sck_fell = tick;
    if (hx->powered_down) {
        hx->powered_down = false;
        restart(hx, tick, 1.0 / hx711_rate_hz(hx));
        return;
    }
    if (hx->fault.cable_out) { return; }
    if (high > hx->stats.sck_high_max_ticks) { hx->stats.sck_high_max_ticks = high; }
    if (high < hx->stats.sck_high_min_ticks) { hx->stats.sck_high_min_ticks = high; }
    if (high > hx->limit.t3_max) { hx->stats.sck_high_too_long++; }
    if (high < hx->limit.t3_min) { hx->stats.sck_high_too_short++; }
}

void hx711_sck(hx711_t *hx, uint64_t tick, uint8_t level)
{
    hx711_advance(hx, tick);
    if (level == hx->sck) { return; }
    hx->sck = level;
    if (level) {
        sck_up(hx, tick);
    } else {
        sck_down(hx, tick);
    }
}

/* --- power and faults --- */

void hx711_start(hx711_t *hx, uint64_t tick, double first_conversion_s)
{
    hx->powered_down = false;
    hx->gain         = 128;
    restart(hx, tick, first_conversion_s);
}

void hx711_power_on(hx711_t *hx, uint64_t tick)
{
    hx711_start(hx, tick, 1.0 / hx711_rate_hz(hx));
}

/* A clock that runs at another rate from now on: the conversion under way too. */
static void replan(hx711_t *hx, uint64_t tick)
{
    const hx711_record_t *last = last_record(hx);
    const double          from = last ? (double)last->tick : (double)tick;
    const double          next = from + hx->hz / hx711_rate_hz(hx);

    hx711_schedule_from(hx, next > (double)tick ? next : (double)(tick + 1U));
}

/* A cable put back powers the part up anew. */
void hx711_set_fault(hx711_t *hx, uint64_t tick, const hx711_fault_t *fault)
{
    const bool   back    = hx->fault.cable_out && !fault->cable_out;
    const double rate_hz = hx711_rate_hz(hx);

    hx711_advance(hx, tick);
    hx->fault = *fault;
    if (hx711_rate_hz(hx) != rate_hz) { replan(hx, tick); }
    if (back || hx->fault.restarted) { hx711_power_on(hx, tick); }
    hx->fault.restarted = 0;
    if (hx->fault.late_ticks) {
        const double next = (double)hx711_scheduled_tick(hx) + (double)hx->fault.late_ticks;
        hx711_schedule_from(hx, next);
        hx->fault.late_ticks = 0;
    }
    tell(hx, tick);
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "hx711.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Datasheet p. 5; minima are rounded up, maxima down, T2 up: the strict reading. */
static void set_limits(hx711_t *hx)
{
    const double us = hx->hz * 1e-6;

    hx->limit.t1         = (uint64_t)ceil(0.1 * us);
    hx->limit.t2         = (uint64_t)ceil(0.1 * us);
    hx->limit.t3_min     = (uint64_t)ceil(0.2 * us);
    hx->limit.t3_max     = (uint64_t)floor(50.0 * us);
    hx->limit.t4_min     = (uint64_t)ceil(0.2 * us);
    hx->limit.power_down = (uint64_t)floor(60.0 * us) + 1U;
}

hx711_t *hx711_new(double ticks_per_s, const hx711_config_t *config)
{
    hx711_t *hx = calloc(1, sizeof *hx);

    if (!hx) { return NULL; }
    hx->config       = *config;
    hx->hz           = ticks_per_s;
    hx->constant     = true;
    hx->gain         = 128;
    hx->dout         = 1;
    hx->line         = 1;
    hx->pending_tick = UINT64_MAX;
    hx->noise_state  = config->seed;
    hx->jitter_state = config->seed ^ 0x6A697474657200ULL;
    hx->flip_state   = config->seed ^ 0x666C697000ULL;

    hx->stats.sck_high_min_ticks = UINT64_MAX;
    hx->stats.sck_low_min_ticks  = UINT64_MAX;
    set_limits(hx);
    return hx;
}

void hx711_free(hx711_t *hx)
{
    if (!hx) { return; }
    free(hx->records);
    free(hx);
}

void hx711_connect(hx711_t *hx, hx711_dout_fn dout_moved, hx711_source_fn source, void *ctx)
{
    hx->dout_moved = dout_moved;
    hx->source     = source;
    hx->ctx        = ctx;
}

void hx711_set_constant(hx711_t *hx, double counts)
{
    hx->constant        = true;
    hx->constant_counts = counts;
}

void hx711_set_source(hx711_t *hx)
{
    hx->constant        = false;
    hx->schedule.valued = false;
}

void hx711_restate(hx711_t *hx)
{
    hx->schedule.valued = false;
    if (hx->dout_moved) { hx->dout_moved(hx->ctx, hx->line_moved, hx->line); }
}

void hx711_get_fault(const hx711_t *hx, hx711_fault_t *fault)
{
    *fault = hx->fault;
}

uint8_t hx711_dout(const hx711_t *hx)
{
    return hx->line;
}

uint64_t hx711_dout_changed_tick(const hx711_t *hx)
{
    return hx->line_moved;
}

void hx711_get_stats(const hx711_t *hx, hx711_stats_t *stats)
{
    *stats = hx->stats;
}

uint32_t hx711_record_count(const hx711_t *hx)
{
    return hx->record_count;
}

void hx711_get_records(const hx711_t *hx, hx711_record_t *records, uint32_t first, uint32_t n)
{
    if (n) { memcpy(records, hx->records + first, n * sizeof *records); }
    /* a frame still open counts as it stands */
    if (n && first + n == hx->record_count && hx->ready) {
        records[n - 1U].pulses = hx->pulses;
        records[n - 1U].read   = hx->pulses >= 25U;
    }
}

/* SPDX-License-Identifier: MIT */
#include "blocks.h"

#include <string.h>

#include "fixed.h"
#include "mass.h"

/* fir_update over a block in float64, where all of it is exact: a folded sample is below 2^25, a
 * product below 2^40, a sum below 2^41, and float64 holds 2^53. So the order of the sums is free,
 * and a compiler does several results at once, for which it has no 64-bit integers. */
enum { LANES = 8, TILE = 512 };

typedef struct {
    double  row[FIR_TAPS_MAX + TILE]; /* the window's samples, the oldest first, then the tile's */
    double  half[FIR_HALF_MAX];
    int     taps;
    int32_t sums[TILE]; /* results before they are limited, |.| <= 2^24 */
} fold_t;

static uint8_t next_place(const fir_t *fir, uint8_t place)
{
    return (uint8_t)((place / FIR_SAMPLE_BYTES + 1) % fir->config->taps * FIR_SAMPLE_BYTES);
}

static void fold_begin(fold_t *fold, const fir_t *fir)
{
    fold->taps = fir->config->taps;
    for (int k = 0; 2 * k < fold->taps; ++k) { fold->half[k] = fir->config->half_q15[k]; }
    uint8_t place = fir->next;
    for (int k = 0; k < fold->taps; ++k) {
        const uint8_t *bytes = &fir->window[place];
        fold->row[k] = (double)((bytes[0] | bytes[1] << 8 | bytes[2] << 16) + FIXED_COUNTS_MIN);
        place        = next_place(fir, place);
    }
}

/* Where the loader can choose, the machine at hand gets its wide registers: twice as fast.
 * There is no rounding that could differ. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define FOR_THIS_MACHINE __attribute__((target_clones("avx2", "default")))
#else
#define FOR_THIS_MACHINE
#endif

/* All sums of a tile; those behind the last sample are of whatever stands there. */
FOR_THIS_MACHINE
static void fold_tile(fold_t *fold, int count)
{
    const int pairs = fold->taps / 2;

    for (int at = 0; at < count; at += LANES) {
        const double *older = &fold->row[at + 1];
        const double *newer = &fold->row[at + fold->taps];
        double        sums[LANES];

        for (int lane = 0; lane < LANES; ++lane) { sums[lane] = 1 << 14; } /* round half up */
        for (int k = 0; k < pairs; ++k) {
            for (int lane = 0; lane < LANES; ++lane) {
                sums[lane] += fold->half[k] * (older[lane + k] + newer[lane - k]);
            }
        }
        if (fold->taps % 2 != 0) {
            for (int lane = 0; lane < LANES; ++lane) {
                sums[lane] += fold->half[pairs] * older[lane + pairs];
            }
        }
        /* A conversion cuts towards zero; of a positive number that is rounding down. */
        for (int lane = 0; lane < LANES; ++lane) {
            fold->sums[at + lane] = (int32_t)(sums[lane] / (1 << 15) + (1 << 25)) - (1 << 25);
        }
    }
}

static void fold_end(const fold_t *fold, fir_t *fir, size_t count)
{
    const size_t taps  = fir->config->taps;
    const size_t size  = FIR_SAMPLE_BYTES * taps;
    const bool   twice = 2U * size <= sizeof fir->window;
    const size_t steps = (fir->next / FIR_SAMPLE_BYTES + count) % taps;
    uint8_t      place = (uint8_t)(FIR_SAMPLE_BYTES * steps);

    fir->next = place;
    for (size_t k = 0U; k < taps; ++k) {
        const uint32_t offset = (uint32_t)((int32_t)fold->row[k] - FIXED_COUNTS_MIN);
        for (size_t byte = place; byte <= place + size * twice; byte += size) {
            fir->window[byte]      = (uint8_t)offset;
            fir->window[byte + 1U] = (uint8_t)(offset >> 8);
            fir->window[byte + 2U] = (uint8_t)(offset >> 16);
        }
        place = next_place(fir, place);
    }
}

static int32_t limited(int32_t value)
{
    const int32_t low = value < FIXED_COUNTS_MIN ? (int32_t)FIXED_COUNTS_MIN : value;
    return low > FIXED_COUNTS_MAX ? (int32_t)FIXED_COUNTS_MAX : low;
}

/* Limited samples behind the row's window; gives how many had to be. */
FOR_THIS_MACHINE
static int fold_fill(fold_t *fold, const int32_t samples[], int count)
{
    double *row     = &fold->row[fold->taps];
    int     clipped = 0;

    for (int i = 0; i < count; ++i) {
        const int32_t sample = limited(samples[i]);
        row[i]               = sample;
        clipped += sample != samples[i];
    }
    return clipped;
}

FOR_THIS_MACHINE
static int fold_give(const fold_t *fold, int32_t results[], int count)
{
    int clipped = 0;

    for (int i = 0; i < count; ++i) {
        results[i] = limited(fold->sums[i]);
        clipped += results[i] != fold->sums[i];
    }
    return clipped;
}

void blocks_fir(fir_t *fir, const int32_t samples[], int32_t results[], size_t count)
{
    fold_t fold    = {0};
    size_t clipped = fir->clipped;

    fold_begin(&fold, fir);
    for (size_t done = 0U; done < count;) {
        const size_t left = count - done;
        const int    tile = left < TILE ? (int)left : TILE;

        clipped += (size_t)fold_fill(&fold, &samples[done], tile);
        fold_tile(&fold, tile);
        clipped += (size_t)fold_give(&fold, &results[done], tile);
        memmove(fold.row, &fold.row[tile], (size_t)fold.taps * sizeof fold.row[0]);
        done += (size_t)tile;
    }
    fold_end(&fold, fir, count);
    fir->clipped = clipped < UINT16_MAX ? (uint16_t)clipped : UINT16_MAX;
}

void blocks_weight_kf(weight_kf_t *kf, const int32_t measured[], int32_t estimates_q7[],
                      size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        estimates_q7[at] = weight_kf_update(kf, measured[at]);
    }
}

void blocks_mass(const int32_t kf_q7[], int32_t tare_q7, uint32_t span_ug_per_count_q16,
                 int32_t mass_mg[], size_t count)
{
    /* |kf|, |tare| <= 2^30, as weight_kf.h has it and the caller has checked */
    for (size_t at = 0U; at < count; ++at) {
        mass_mg[at] = mass_from_counts(kf_q7[at] - tare_q7, span_ug_per_count_q16);
    }
}

frame_status_t blocks_decode(frame_decoder_t *decoder, const uint8_t bytes[], size_t count,
                             size_t *used)
{
    for (*used = 0U; *used < count;) {
        const frame_status_t status = frame_decoder_push(decoder, bytes[(*used)++]);
        if (status != FRAME_PENDING) { return status; }
    }
    return FRAME_PENDING;
}

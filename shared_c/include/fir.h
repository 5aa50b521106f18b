/* SPDX-License-Identifier: MIT */
/* fir - symmetric (linear-phase) FIR filter for 24-bit converter counts.
 *
 * Model     y[n] = sum_k c[k] x[n-k],  c[k] = c[N-1-k],  sum_k c[k] = 1
 * Result    (sum_k c_q15[k] x[n-k] + 2^14) >> 15 in unbounded integers (round half up), then
 *           saturated to 24 bits and counted. CMSIS-DSP's q15 truncates and its q31 wraps; this
 *           does neither.
 * Formats   sample and result: counts, |x| <= 2^23, in int32    coefficients: Q15, sum 32768,
 *           sum |c| < 65536, the first half in ROM
 * Delay     (taps - 1) / 2 samples, exactly, at every frequency
 * Start     primed: init fills the window with one value, so that there is no ramp from zero
 * Bad data  a sample beyond 24 bits is clamped and counted in `clipped`; update cannot fail
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef FIR_H
#define FIR_H

#include <stdint.h>

enum { FIR_TAPS_MAX = 32 };

typedef struct {
    const int16_t *half_q15; /* ROM: the first taps/2 coefficients; the second half mirrors them */
    uint8_t        taps;     /* even, 2..FIR_TAPS_MAX */
} fir_config_t;

typedef struct {
    const fir_config_t *config;
    uint8_t  window[6 * FIR_TAPS_MAX]; /* counts + 2^23 in 3 bytes, each kept twice: no wrap */
    uint8_t  next;                     /* where the next sample goes, 0..taps-1 */
    uint16_t clipped;                  /* samples and results clamped, stops at 65535 */
} fir_t;

/* Prime the filter: it answers first_counts for ever if it is fed first_counts. */
void fir_init(fir_t *fir, const fir_config_t *config, int32_t first_counts);

/* Take one sample, give one result. */
int32_t fir_update(fir_t *fir, int32_t sample_counts);

#endif

/* SPDX-License-Identifier: MIT */
/* fir - symmetric (linear-phase) FIR filter for 24-bit converter counts.
 *
 * Model     y[n] = sum_k c[k] x[n-k],  c[k] = c[N-1-k],  sum_k c[k] = 1
 * Result    (sum_k c_q15[k] x[n-k] + 2^14) >> 15 in unbounded integers (round half up), then
 *           saturated to 24 bits and counted. CMSIS-DSP's q15 truncates and its q31 wraps; this
 *           does neither.
 * Formats   sample and result: counts, |x| <= 2^23, in int32    coefficients: Q15, sum 32768,
 *           sum |c| < 65536, the first half, the middle one of an odd number included
 * Delay     (taps - 1) / 2 samples, exactly, at every frequency
 * Start     primed: init fills the window with one value, so that there is no ramp from zero
 * Designs   in ROM (fir_designs.h), chosen when the program runs: fir_init with another one; or
 *           one that is loaded into RAM, refused where it breaks the contract
 * Two ways  fir_update, a loop for any design; fir_update_default, straight code for the default
 *           design, quicker and larger. The same answers and the same state: either may take any
 *           sample. Of the window only what the samples fill is touched: 3 bytes each, and as many
 *           again where the configuration is fir_designs[0] itself
 * Bad data  a sample beyond 24 bits is clamped and counted in `clipped`; update cannot fail
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef FIR_H
#define FIR_H

#include <stdbool.h>
#include <stdint.h>

enum { FIR_TAPS_MAX = 64, FIR_HALF_MAX = 32, FIR_SAMPLE_BYTES = 3 };

/* The AVR's port_fir.S knows the order of these fields. */
typedef struct {
    const int16_t *half_q15; /* the first (taps + 1) / 2 coefficients; the others mirror them */
    uint8_t        taps;     /* 2..FIR_TAPS_MAX */
    bool           loaded;   /* half_q15 lies in RAM; else in ROM */
} fir_config_t;

typedef struct {
    const fir_config_t *config;
    uint16_t            clipped; /* samples and results clamped, stops at 65535 */
    uint8_t next; /* where the next sample goes: a byte of the window, 0, 3 .. 3 (taps - 1) */
    uint8_t window[FIR_SAMPLE_BYTES * FIR_TAPS_MAX]; /* counts + 2^23, least byte first; those of
                                                         fir_designs[0] twice, in a row */
} fir_t;

/* Take coefficients from settings into a configuration. half_q15 is not copied and must stay.
 * False, and the configuration untouched, where the contract above does not hold. */
bool fir_load(fir_config_t *config, const int16_t half_q15[], uint8_t taps);

/* Prime the filter: it answers first_counts for ever if it is fed first_counts. */
void fir_init(fir_t *fir, const fir_config_t *config, int32_t first_counts);

/* Take one sample, give one result. */
int32_t fir_update(fir_t *fir, int32_t sample_counts);

/* As fir_update; quicker if the configuration is fir_designs[0], in which the design's coefficients
 * are part of the code. */
int32_t fir_update_default(fir_t *fir, int32_t sample_counts);

/* Group delay in half samples: what the results are late by, whatever the frequency. */
uint8_t fir_delay_half_samples(const fir_config_t *config);

#endif

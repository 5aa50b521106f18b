/* SPDX-License-Identifier: MIT */
/* weight_kf_adaptive - scalar Kalman filter that is quiet at rest and quick when the load steps.
 *
 * Model     as weight_kf, with what is constant there taken from the data here. With x the
 *           estimate, P its variance, sigma the noise as learnt, R = sigma^2, nu = z - x:
 *   test    x may lie 3 sigma outside of what the last three measurements span, and is moved there
 *           by J if it lies farther: one innovation with nu^2 > 9 R is a spike and moves nothing,
 *           three of one sign are a step. (Normalised innovation squared, by its root: sigma is
 *           at hand, so nothing is divided.)
 *   update  P = P + Q;  S = P + R;  N = max(P, min(|J| sigma / 8, S));  K = N / S
 *           x = x + K (z - x), z - x limited to 4 sigma;  P = (1 - K) P, or K R where J opened it
 *   learn   sigma = sigma + 2^-8 (sqrt(pi/2) |z - x| - sigma), z - x as above, and limited to
 *           4 sigma - |J| or to sigma, whichever is more: the innovations' scale by their mean
 *           magnitude, which spikes move less than Mehra's mean square (1970). P beside R is
 *           neglected: sigma is high by K / 2.
 *           All this is continuous in the data: no rounding error grows by a decision.
 *   pair    two models. A second filter of gain 1/2 follows a moving load. Where x lies 6 sigma
 *           outside of the three, it takes over; 8 of its innovations in a row below 3 sigma hand
 *           back. While it moves, the resting filter stands still, so that no state is lost when
 *           the load steps back: within 2 sigma of where it was, it goes on as if nothing had been;
 *           else it starts from where the moving one stands, with P = R / 2. These are decisions:
 *           rounding may move one by a sample where the data is on the brink.
 * Formats   measurement: counts, |z| <= 2^23, in int32    estimate: counts, Q7 in int32
 *           variances: counts^2, Q16 in uint32    noise: counts, Q16 in uint32, 1..127
 *           gain: Q16, 1 - 2^-16 at most
 *           what the gain takes of J: whole 1/32 counts, at most 2048
 * Rounding  K and the estimate given: down; what is given is 2^-7 of a count fine, but x itself is
 *           kept in Q23, or a small gain would leave it standing. P and sigma: half up
 * Bad data  a measurement beyond 24 bits is clamped and counted in `clipped`; update cannot fail
 * Context   single caller, not from an ISR. No division routine: K comes bit by bit, in constant
 *           time.  Cost: firmware/budget.toml
 */
#ifndef WEIGHT_KF_ADAPTIVE_H
#define WEIGHT_KF_ADAPTIVE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint16_t process_var_q16; /* Q, counts^2 a sample */
    uint16_t noise_q8;        /* sigma to begin with, counts rms ... */
    uint16_t noise_min_q8;    /* ... and its bounds: 1 <= min <= noise <= max < 128 counts */
    uint16_t noise_max_q8;
} weight_kf_adaptive_config_t;

typedef struct {
    const weight_kf_adaptive_config_t *config;

    int32_t  estimate_counts_q7;  /* x, |.| <= 2^30 */
    uint32_t var_q16;             /* P, <= R + Q */
    uint32_t noise_q16;           /* sigma */
    int32_t  before_counts_q7[2]; /* the last measurement and the one before, |.| <= 2^30 */
    uint16_t fraction_q23;        /* of x, what Q7 does not hold: 0..2^-7 */
    uint16_t clipped;             /* measurements clamped to 24 bits, stops at 65535 */
} weight_kf_adaptive_t;

/* Start at first_counts, as sure of it as of one measurement. */
void weight_kf_adaptive_init(weight_kf_adaptive_t *kf, const weight_kf_adaptive_config_t *config,
                             int32_t first_counts);

/* Take one measurement, give the new estimate (Q7). */
int32_t weight_kf_adaptive_update(weight_kf_adaptive_t *kf, int32_t measured_counts);

typedef struct {
    weight_kf_adaptive_t rest;
    int32_t              moving_counts_q7; /* the moving model's estimate, |.| <= 2^30 */
    uint8_t              quiet;            /* its innovations in a row that were small */
    bool                 moving;           /* it has the say */
} weight_kf_adaptive_pair_t;

void weight_kf_adaptive_pair_init(weight_kf_adaptive_pair_t         *pair,
                                  const weight_kf_adaptive_config_t *config, int32_t first_counts);

/* Take one measurement, give the estimate (Q7) of the model that has the say. */
int32_t weight_kf_adaptive_pair_update(weight_kf_adaptive_pair_t *pair, int32_t measured_counts);

#endif

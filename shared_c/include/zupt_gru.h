/* SPDX-License-Identifier: MIT */
/* zupt_gru - tells when a foot stands still for a moment: zupt's question, answered by a learnt
 * detector, eight gated recurrent units that see two magnitudes.
 *
 * Model     Cho et al. 2014, in the order and with the two biases of PyTorch's GRU: of the inputs x
 *           and the state h
 *             r = s(W_r x + U_r h + b_r),  z = s(W_z x + U_z h + b_z)          s: sigmoid
 *             n = tanh(W_n x + b_n + r (U_n h + c_n)),  h' = n + z (h - n)
 *           still where the score w h' + b comes up to what is asked: 0, a probability of `accept`,
 *           or a margin below the best score of the newest blocks, but not below a least one. What
 *           is never as still as the walkers that were learnt from would otherwise never stand
 *           x: | |a| - g | and |w|, in octaves above a floor, ten of them at most
 * Steps     one every ZUPT_GRU_STEP_MS, of the newest sample there is: the call that takes it draws
 *           the magnitudes and runs the first units, the next call runs the others and decides
 * Formats   samples: counts in int16, calibrated (imu_cal), 2048 are 1 g, 16.384 are 1 deg/s
 *           x: octaves Q10, 0..10 2^10     h: Q13, +-1 at most     weights: int8, by 51.2; ROM
 * Rounding  shared_c/notes/zupt_gru.md has each, and how far from the network in floats they lead
 * Bad data  a value beyond +-ZUPT_GRU_VALUE_MAX, which is 4 g or 500 deg/s, is ten octaves, and no
 *           step with ten octaves is still; a vector on a rail is counted in `rejected` too
 * Gaps      after a gap in time call zupt_gru_interrupt
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef ZUPT_GRU_H
#define ZUPT_GRU_H

#include <stdint.h>

#include "zupt.h" /* ZUPT_STILL */

enum {
    ZUPT_GRU_UNITS     = 8,
    ZUPT_GRU_FIRST     = 3, /* as many units run in a step's first call */
    ZUPT_GRU_INPUTS    = 2,
    ZUPT_GRU_STEP_MS   = 5,
    ZUPT_GRU_BLOCK_LEN = 64, /* steps of which the best score is kept */
    ZUPT_GRU_BLOCKS    = 3,
    ZUPT_GRU_VALUE_MAX = 8191,    /* and down to -8192 */
    ZUPT_GRU_OCTAVES   = 10 << 10 /* the largest input */
};

typedef struct {
    int16_t  seen[ZUPT_GRU_INPUTS + ZUPT_GRU_UNITS]; /* octaves Q10, then the state in Q13 */
    int16_t  next[ZUPT_GRU_FIRST];                   /* states of the first units, Q13 */
    int16_t  best[ZUPT_GRU_BLOCKS];                  /* score of each block, the newest first */
    uint16_t rejected;                               /* vectors on a rail, stops at 65535 */
    uint8_t  sample_ms;                              /* from a sample to the next, 1 or 2 */
    uint8_t  wait_ms;                                /* to the next step */
    uint8_t  steps;                                  /* of the newest block */
    uint8_t  still;                                  /* ZUPT_STILL or 0 */
} zupt_gru_t;

/* Begin, not still, at 1 kHz (1) or 500 Hz (2). gru is all zero or was in use: its `rejected` is
 * kept. */
void zupt_gru_init(zupt_gru_t *gru, uint8_t sample_ms);

/* Take one sample; gives ZUPT_STILL or 0. */
uint8_t zupt_gru_update(zupt_gru_t *gru, const int16_t gyro_b_counts[3],
                        const int16_t acc_b_counts[3]);

/* Samples were lost, or a sensor was off: not still, and the network begins anew; the blocks begin
 * with a score of 0 each. */
void zupt_gru_interrupt(zupt_gru_t *gru);

#endif

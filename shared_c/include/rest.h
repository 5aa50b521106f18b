/* SPDX-License-Identifier: MIT */
/* rest - knows when the board lies still, and learns the gyroscope's bias while it does.
 *
 * Model     every axis of accelerometer and gyroscope has a low-pass; the board is at rest when for
 *           some time no axis has left its low-pass by more than a limit, and none turns faster
 *           than any bias would be (after Laidig and Seel 2023, VQF, sec. 3.4). What leaves it
 *           starts it anew. The bias is a mean over blocks seen at rest: the n-th learnt moves it
 *           by 2^-floor(log2 n) of the distance, which is nearly the mean of them all, until
 *           gain_len holds the gain: then the mean is exponential and follows temperature
 * Hysteresis in time (rest begins late and ends at once) and in the limits (enter <= leave)
 * Start     until the first block was learnt an eighth of the stillness is enough: an attitude
 *           without bias drifts away meanwhile
 * Visits    each call looks at one axis of one sensor, accelerometer x y z, gyroscope x y z, in
 *           turn: a round is six samples. A block is REST_BLOCK_ROUNDS rounds that gather, and one
 *           whose first visit weighs gravity and whose last three learn, in place of looking; if
 *           anything breaks it off, the block begins anew
 * Formats   samples: counts in int16, calibrated (imu_cal)    low-passes, bias: counts, Q16
 *           low-pass's gain: Q16    gravity: its low-pass in steps of 256 counts, half up, squared
 * Rounding  low-pass: its whole counts are compared, so that it settles within one; bias: down, so
 *           that it settles less than 2^-16 gain_len counts below the mean
 * Bad data  a sample on a rail is no rest, stays out of the low-pass and is counted in `rejected`;
 *           a block in which the accelerometer does not feel about 1 g is not learnt (dead or stuck
 *           sensor) and is counted in `implausible`; update cannot fail
 * Gaps      after a gap in time call rest_interrupt: rest must begin anew, the bias is kept
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef REST_H
#define REST_H

#include <stdbool.h>
#include <stdint.h>

enum {
    REST_BLOCK_ROUNDS   = 16,
    REST_FIRST_SHIFT    = 3,    /* still_rounds / 8 do until the bias is known */
    REST_GYRO_LIMIT_MAX = 2046, /* leave_gyro + bias_max, so that a block fits int16 */
    REST_ACC_LIMIT_MAX  = 16383
};

/* Bits of what rest_update answers. */
enum {
    REST_AT_REST    = 1,
    REST_BIAS_KNOWN = 2 /* at least one block was learnt */
};

typedef struct {
    /* How far off its low-pass a sample may lie: accelerometer, gyroscope; in motion, at rest. */
    int16_t  limit_counts[2][2];
    int16_t  bias_max_counts; /* a low-passed gyroscope beyond it turns */
    int16_t  lowpass_q16;     /* 1..32767, gain of one visit */
    uint8_t  still_rounds;    /* as many without motion make rest, 1..255; at first an eighth,
                                 rounded down, at least one */
    uint8_t  gain_len;        /* blocks until the mean is exponential, 1..255 */
    uint16_t gravity2_min;    /* (256 counts)^2, square of the low-passed acceleration */
    uint16_t gravity2_max;
} rest_config_t;

typedef struct {
    const rest_config_t *config;
    int32_t              bias_q16[3];   /* gyroscope, counts, Q16: take this off it */
    int32_t              low_q16[6];    /* accelerometer, gyroscope, counts, Q16 */
    int16_t              sum_counts[3]; /* of the gyroscope over the block so far */
    uint16_t             rejected;      /* samples on a rail, stops at 65535 */
    uint16_t             implausible;   /* blocks not learnt, stops at 65535 */
    uint8_t              visit;         /* the next: accelerometer 0..2, gyroscope 3..5 */
    uint8_t              rounds;        /* ended since motion or, at rest, in this block */
    uint8_t              blocks;        /* learnt, stops at gain_len */
    uint8_t              flags;         /* what rest_update answers */
} rest_t;

/* The bounds above hold, so that nothing overflows. */
bool rest_is_lawful(const rest_config_t *config);

/* Begin, not at rest, bias zero.  config must be lawful, and stay; those of rest_configs.h are in
 * ROM, to be copied. */
void rest_init(rest_t *rest, const rest_config_t *config);

/* Take one sample; gives REST_AT_REST and REST_BIAS_KNOWN as bits. */
uint8_t rest_update(rest_t *rest, const int16_t gyro_b_counts[3], const int16_t acc_b_counts[3]);

/* Samples were lost, or a sensor was off: no rest until it has been still anew. */
void rest_interrupt(rest_t *rest);

#endif

/* SPDX-License-Identifier: MIT */
/* zupt - tells when the board stands still for a moment, within a step even: the four classical
 * detectors of zero velocity. rest asks for seconds of stillness, and learns from them.
 *
 * Model     Skog, Haendel, Nilsson and Rantakokko 2010, sec. III: a block of n = ZUPT_BLOCK rates w
 *           and accelerations a, of mean m, against gravity g, is quiet where its sum of squares is
 *           below a limit:
 *             shoe             weight sum |w|^2 + sum |a - m|^2 + n ((|m|^2 - g^2) / 2g)^2
 *             are              weight sum |w|^2, the angular rate's energy
 *             moving_variance  sum |a - m|^2
 *             magnitude        4 sum ((|a|^2 - g^2) / 2g)^2
 *           The bracket is |a| - g to first order, so that no root is drawn. With that, shoe's is
 *           sum |a - g m/|m||^2, the generalised likelihood; notes/zupt.md has the difference
 * Visits    one visit every `stride` samples: accelerometer and gyroscope in turn, n of each, then
 *           one that judges: ZUPT_VISITS visits are a block
 * Hysteresis in the limits (that of leaving is higher) and in time: still begins with the
 *           still_blocks-th quiet block in a row and ends with the first that is not quiet
 * Formats   samples: counts in int16, calibrated (imu_cal), 1 g is ZUPT_GRAVITY_COUNTS
 * Rounding  the brackets' quotients and |sum a|^2 / n are rounded down
 * Bad data  a value beyond +-ZUPT_VALUE_MAX, which is 2 g or 250 deg/s, is motion at once; one on a
 *           rail is counted in `rejected` too. A detector looks at the sensors that it needs only
 * Gaps      after a gap in time call zupt_interrupt
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef ZUPT_H
#define ZUPT_H

#include <stdbool.h>
#include <stdint.h>

enum {
    ZUPT_BLOCK          = 4,
    ZUPT_VISITS         = 2 * ZUPT_BLOCK + 1,
    ZUPT_GRAVITY_COUNTS = 2048,
    ZUPT_VALUE_MAX      = 4095, /* and down to -4096: no sum leaves int32 (notes) */
    ZUPT_WEIGHT_MAX     = 6
};

/* Detectors. The odd ones take the accelerations' mean off. */
enum { ZUPT_OFF = 0, ZUPT_SHOE = 1, ZUPT_ARE = 2, ZUPT_MOVING_VARIANCE = 3, ZUPT_MAGNITUDE = 4 };

enum { ZUPT_STILL = 1 }; /* what zupt_update answers, or 0 */

typedef struct {
    int32_t
        begin_squares[2]; /* minus the limit, counts^2: in motion, and while still <= that < 0 */
    uint8_t detector;
    uint8_t acc_weight;   /* moving_variance, shoe 1, are 0, magnitude 16 */
    uint8_t gyro_weight;  /* shoe, are 1..ZUPT_WEIGHT_MAX, others 0 */
    uint8_t still_blocks; /* as many quiet ones in a row make it still, 1..255 */
    uint8_t stride;       /* samples a visit, 1..255 */
} zupt_config_t;

typedef struct {
    zupt_config_t config;
    int32_t       squares;    /* of the block so far, counts^2 above its limit */
    int16_t       sum_acc[3]; /* of the block so far, counts */
    uint16_t      rejected;   /* samples on a rail, stops at 65535 */
    uint8_t       visit;      /* the next of the block */
    uint8_t       wait;       /* samples before it */
    uint8_t       quiet;      /* blocks in a row, while not still */
    uint8_t       still;      /* ZUPT_STILL or 0 */
} zupt_t;

/* The bounds above hold, so that nothing overflows. */
bool zupt_is_lawful(const zupt_config_t *config);

/* Begin, not still.  config must be lawful; it is copied. */
void zupt_init(zupt_t *zupt, const zupt_config_t *config);

/* Begin with a detector of zupt.toml, not still. Any other number is ZUPT_OFF: all zero, with which
 * no block is quiet. `rate` is one of zupt_configs.h, a stride. zupt is all zero or was in use: its
 * `rejected` is kept. */
void zupt_choose(zupt_t *zupt, uint8_t detector, uint8_t rate);

/* Take one sample; gives ZUPT_STILL or 0. */
uint8_t zupt_update(zupt_t *zupt, const int16_t gyro_b_counts[3], const int16_t acc_b_counts[3]);

/* Samples were lost, or a sensor was off: not still until blocks have been quiet anew. */
void zupt_interrupt(zupt_t *zupt);

#endif

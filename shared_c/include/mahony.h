/* SPDX-License-Identifier: MIT */
/* mahony - attitude from gyroscope and accelerometer (6 axes), and magnetometer (9 axes).
 *
 * Model     The explicit complementary filter (Mahony, Hamel, Pflimlin 2008, eq. 32) with its
 *           correction taken in the world frame, X and Y being the acceleration along its level
 *           axes in g. All three modes turn the world by kp (uy, -ux, 0) rad/s:
 *             second order   u' = lp (X - u): acceleration is averaged before it corrects. This is
 *                            the core of VQF (Laidig and Seel 2023) in one third of its states
 *             linear         u  = X: Mahony with an acceleration that is never normalised
 *             classic        u  = X / |a|: Mahony as the literature has it, with kp and ki
 *           Magnetometer: turns about the vertical only, by the sine of the field's azimuth, so
 *           that no field can tilt the estimate. notes/mahony.md derives all of it.
 * Frames    world: x east, y north (magnetic; free without magnetometer), z up;
 *           quat_wb takes body vectors to world, scalar first
 * Formats   gyr: int16, scale in the configuration (one of +-250..2000 deg/s)
 *           acc: int16, specific force, at rest +1 g upwards; +-8 or +-16 g is advised, because
 *                only what is not clipped averages to zero
 *           mag: int16, calibrated, up to 11585 counts along any axis of the world
 *           bias_q16: what `rest` has learnt, gyr LSB Q16, |bias| <= 2^25 (512 LSB)
 * Accuracy  against float64 with the same constants: notes/mahony.md
 * Start     acceleration stands the estimate upright at once for MAHONY_START_LEN blocks, half a
 *           second, at any attitude; then gains fall from eightfold to one. The heading begins as
 *           it is and is the field's after some 4000 samples of it
 * Bad data  counted in `counts`: acceleration exactly zero is skipped, rails of gyr and acc are
 *           used as they are, a field that is zero or vertical is skipped, a disturbed field is
 *           bridged. After lost samples call mahony_gap. update cannot fail; counters stop at 65535
 * Norm      of mahony_quaternion's result: 1 within 1e-6, always
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml, nearly constant
 * State     plain bytes: a copy continues identically
 */
#ifndef MAHONY_H
#define MAHONY_H

#include <stdbool.h>
#include <stdint.h>

/* Constants for one rate: of spec/mahony.toml by ./dev gen, for any other rate of
 * terazi.design.mahony. In the caller's memory for as long as the filter. */
typedef struct {
    uint16_t gyro_q33;        /* half angle of a gyroscope's count in one step, 1..16128 */
    uint16_t square;          /* 1 - cosine in Q33, by |rate|^2 / 2^16: gyro_q33^2 / 2^18, <= 993 */
    uint16_t cubic;           /* loss of gyro_q33 in Q16, by 1 - cosine in Q17; <= 2700 */
    uint16_t lowpass_q16;     /* lp dt, <= 4095; 0 but for the second order */
    uint16_t correct_q18;     /* kp dt, by g in Q25: 2048 counts a g; 1..4095 */
    uint16_t acc_one_g;       /* counts a g, <= 32767 */
    uint8_t  ramp_mask;       /* samples of each block of start and ramp, 2^n, less 1 */
    uint8_t  gap_max;         /* samples bridged with the last rate; after more: start anew */
    uint8_t  start_shift;     /* rate by which a start turns: acc in Q14 by 2^this; <= 30 */
    uint16_t mag_correct_q21; /* dt / (2 tau) of the heading, by two samples, <= 14000 */
    uint16_t mag_learn_q16;   /* dt / 20 s, <= 32767; this and what follows by blocks */
    uint16_t mag_recover_len; /* 0.5 s */
    uint16_t mag_accept_len;  /* 20 s */
    uint16_t mag_reject_len;  /* 60 s */
    uint16_t moving_min;      /* counts of 20 deg/s, <= 32767 */
} mahony_config_t;

/* Blocks of a start and of the ramp after it, and samples of a field's block. */
enum { MAHONY_START_LEN = 3, MAHONY_RAMP_LEN = 12, MAHONY_MAG_BLOCK = 8 };

enum { MAHONY_ACC_ZERO = 1, MAHONY_RAILED = 2 };

/* Averaged acceleration along one level axis of the world, and what waits for the next sample. */
typedef struct {
    int32_t  mean_q14; /* u: acc LSB, within +-2^27 */
    uint16_t mean_res;
    uint16_t correct_res;
} mahony_level_t;

/* What one step works on (shared_c/src/port_turn.h), in the order that suits an 8-bit machine. */
typedef struct {
    int32_t  quat_wb_q30[4]; /* norm 1 within 2^-9; mahony_quaternion gives it within 1e-6 */
    int16_t  quat_q14[4];    /* the same in 16 bits; what is cut off is carried to the next ... */
    uint8_t  cut_q22[4];     /* ... in here */
    int16_t  east_b_q14[3];  /* world x in body axes: first row of the rotation matrix */
    int16_t  north_b_q14[3]; /* world y in body axes: second row */
    int16_t  norm_error_q20; /* |quat_q14|^2 - 1 */
    int16_t  rate_b[3];      /* gyr less bias, LSB */
    uint16_t rate_res[3];    /* carries: what was cut off waits for the next sample */
    int16_t  correct_q19;    /* turn of the world in this step, half angle */
    int32_t  level_q14;      /* acceleration along the axis that is averaged next */
    uint8_t  sample;         /* counts: even averages east, odd north */
    uint8_t  flags;          /* MAHONY_ACC_ZERO, MAHONY_RAILED of this step */
    uint16_t turn_res[3];
    uint16_t square_res, loss_res, scale_res;
    uint16_t gyro_q33, square, cubic;  /* of the configuration */
    uint16_t lowpass_q16, correct_q18; /* of the configuration, raised by the ramp */
    mahony_level_t level_w[2];
} mahony_step_t;

typedef struct {
    uint16_t acc_zero; /* samples without any acceleration, skipped */
    uint16_t railed;   /* samples with gyr or acc at a rail, used */
    uint16_t
        mag_refused; /* blocks of a field that is zero or within 3.6 deg of vertical: skipped */
    uint16_t mag_disturbed; /* blocks of fields that differ from the reference, used less or not */
    uint16_t gaps;          /* calls of mahony_gap */
} mahony_counts_t;

/* A field's level and upward part, counts Q16. */
typedef struct {
    int32_t part_q16[2];
} mahony_field_t;

/* The magnetometer's part. Each sample adds its level part to a block; the work on the block before
 * is done beside, a part in each of its samples, so that they cost much the same. */
typedef struct {
    int32_t  sum_q6[2];  /* east and north, of this block */
    int16_t  mean_q1[2]; /* of the block before; then the azimuth's sine, Q14, in east's place */
    uint16_t level_q1;   /* length of that; 0: refused */
    int16_t  now[2];     /* level and upward part, counts */
    mahony_field_t reference;   /* the undisturbed field */
    mahony_field_t candidate;   /* perhaps a new reference */
    uint16_t       undisturbed; /* blocks since the last that was disturbed */
    uint16_t       accepted;    /* blocks in motion for which the candidate has held */
    uint16_t       rejected;    /* blocks of rejection, less those without */
    uint16_t       raised_q21;  /* the heading's gain, high at first; 0: no reference yet */
    uint16_t       correct_q21; /* the same, none or half of it where disturbed */
    uint16_t       turn_res;    /* carry of the heading's correction */
    uint8_t        phase;       /* sample of this block, 0..MAHONY_MAG_BLOCK - 1 */
    bool           whole;       /* there is a block before */
} mahony_mag_t;

typedef struct {
    const mahony_config_t *config;
    uint8_t                ramp_left; /* blocks until gains are one; above MAHONY_RAMP_LEN: start */
    mahony_step_t          step;
    mahony_mag_t           mag;
    mahony_counts_t        counts;
} mahony_t;

/* The bounds above hold, so that nothing overflows. */
bool mahony_is_lawful(const mahony_config_t *config);

/* Identity until the first acceleration comes.  config must be lawful, and stay. */
void mahony_init(mahony_t *mahony, const mahony_config_t *config);

/* One sample of gyroscope and accelerometer; bias_q16 from `rest`, or zeros. */
void mahony_update(mahony_t *mahony, const int16_t gyro_b_counts[3], const int16_t acc_b_counts[3],
                   const int32_t bias_q16[3]);

/* One sample of the magnetometer, after mahony_update, at the rate of the configuration. */
void mahony_update_mag(mahony_t *mahony, const int16_t mag_b_counts[3]);

/* So many samples are missing before the next one: up to gap_max are bridged with the last rate,
 * after more the next acceleration sets the inclination anew. */
void mahony_gap(mahony_t *mahony, uint16_t samples);

/* The attitude, Q30, norm 1 within 1e-6. */
void mahony_quaternion(const mahony_t *mahony, int32_t quat_wb_q30[4]);

/* The vertical in body axes: third row of the rotation matrix. */
void mahony_up(const mahony_t *mahony, int16_t up_b_q14[3]);

/* acc less gravity, in body axes and acc LSB, limited to int16. */
void mahony_free_acceleration(const mahony_t *mahony, const int16_t acc_b_counts[3],
                              int16_t free_b_counts[3]);

/* Aerospace order z-y-x: yaw about world z, then pitch, then roll; rad in Q13. At 90 deg of pitch
 * only the sum or the difference of roll and yaw exists; there the other one keeps the value that
 * it has in *euler, so pass the same struct each time, zero at first. */
typedef struct {
    int16_t  roll_q13;         /* -pi..pi */
    int16_t  pitch_q13;        /* -pi/2..pi/2 */
    int16_t  yaw_q13;          /* -pi..pi, anticlockwise from east to body x */
    uint16_t half_sum_turn16;  /* (yaw + roll) / 2 and (yaw - roll) / 2 when they last existed, */
    uint16_t half_diff_turn16; /* in 2^-16 of a turn */
} mahony_euler_t;

void mahony_euler(const mahony_t *mahony, mahony_euler_t *euler);

/* The same filter in all its modes, at low rates too; a source of its own, which a device that runs
 * the second order in one step a sample does not link. What is above takes `mahony`. */
enum {
    MAHONY_SECOND_ORDER = 0,
    MAHONY_LINEAR       = 1,
    MAHONY_CLASSIC      = 2,
};

typedef struct {
    mahony_config_t usual;
    uint8_t         steps;    /* a sample, 1..255: more than one below 284 Hz at 2000 deg/s */
    uint8_t         mode;     /* MAHONY_SECOND_ORDER .. MAHONY_CLASSIC */
    uint16_t        integral; /* ki: loss of bias in Q24, by turn in Q19, <= 32767; 0: off */
} mahony_modes_config_t;

typedef struct {
    mahony_t                     mahony;
    const mahony_modes_config_t *config;
    int32_t                      integral_q22[3]; /* bias by ki, LSB, |.| <= 328 LSB (20 deg/s) */
    uint16_t                     integral_res;
} mahony_modes_t;

/* The bounds above hold, so that nothing overflows. */
bool mahony_modes_is_lawful(const mahony_modes_config_t *config);

void mahony_modes_init(mahony_modes_t *modes, const mahony_modes_config_t *config);
void mahony_modes_update(mahony_modes_t *modes, const int16_t gyro_b_counts[3],
                         const int16_t acc_b_counts[3], const int32_t bias_q16[3]);
void mahony_modes_gap(mahony_modes_t *modes, uint16_t samples);

#endif

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
 *                only what is not clipped averages to zero.    mag: int16, calibrated
 *           bias_q16: what `rest` has learnt, gyr LSB Q16, |bias| <= 2^25 (512 LSB)
 * Accuracy  against float64 with the same constants: notes/mahony.md
 * Start     from the first acceleration that is not zero, at any attitude; heading from the first
 *           lawful field. Gains begin tenfold and fall to one during the ramp
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

enum {
    MAHONY_SECOND_ORDER = 0,
    MAHONY_LINEAR       = 1,
    MAHONY_CLASSIC      = 2,
};

/* Constants for one rate: of spec/mahony.toml by ./dev gen, for any other rate of
 * terazi.design.mahony. In the caller's memory for as long as the filter. */
typedef struct {
    uint16_t gyro_q33;        /* half angle of a gyroscope's count in one step, 1..16128 */
    uint16_t square;          /* 1 - cosine in Q33, by |rate|^2 / 2^16: gyro_q33^2 / 2^18, <= 993 */
    uint16_t cubic;           /* loss of gyro_q33 in Q16, by 1 - cosine in Q17; <= 2700 */
    uint8_t  steps;           /* a sample, 1..255: more than one below 284 Hz at 2000 deg/s */
    uint8_t  mode;            /* MAHONY_SECOND_ORDER .. MAHONY_CLASSIC */
    uint16_t lowpass_q16;     /* lp dt, <= 32767; 0 but for the second order */
    uint16_t correct_q18;     /* kp dt, by g in Q25: 2048 counts a g; 1..4095 */
    uint16_t integral;        /* ki: loss of bias in Q24, by turn in Q19, <= 32767; 0: off */
    uint16_t ramp_len;        /* of the ramp, in MAHONY_RAMP_BLOCK samples */
    uint16_t ramp_step_q12;   /* 9 / ramp_len; ramp_len ramp_step_q12 <= 65535 */
    uint16_t gap_max;         /* samples bridged with the last rate; after more: start anew */
    uint16_t acc_one_g;       /* counts a g, <= 32767 */
    uint8_t  mag_times_64;    /* 1: the field is counted in less than 512 counts; 0: in more */
    uint16_t mag_correct_q21; /* dt / (2 tau) of the heading, <= 16383; this and what follows by */
    uint16_t mag_smooth_q16;  /* MAHONY_MAG_BLOCK samples.  dt / 50 ms, <= 32767 */
    uint16_t mag_learn_q16;   /* dt / 20 s, <= 32767 */
    uint16_t mag_recover_len; /* 0.5 s */
    uint16_t mag_accept_len;  /* 20 s */
    uint16_t mag_reject_len;  /* 60 s */
    uint16_t mag_settle_len;  /* 1 s: no rejection before */
    uint16_t moving_min;      /* counts of 20 deg/s, <= 32767 */
} mahony_config_t;

enum { MAHONY_RAMP_BLOCK = 16, MAHONY_MAG_BLOCK = 8 };

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

/* A field: norm in counts (or 1/64), limited to 2^15, and sine of its elevation in Q15. */
typedef struct {
    int32_t norm_q16;
    int32_t dip_q31;
} mahony_field_t;

/* The magnetometer's part. Each sample adds its level part to a block; an eighth of the work on the
 * block before is done beside, so that samples cost much the same. */
typedef struct {
    int32_t        east_sum, north_sum; /* of this block, counts or 1/64 */
    int16_t        east, north;         /* mean of the block before */
    uint32_t       level2;              /* square of that */
    int16_t        up;                  /* along the vertical */
    int16_t        norm, dip_q15;       /* of the block before */
    mahony_field_t smooth;              /* smoothed by 50 ms */
    mahony_field_t reference;           /* the undisturbed field */
    mahony_field_t candidate;           /* perhaps a new reference */
    uint16_t       undisturbed;         /* blocks since the last that was disturbed */
    uint16_t       accepted;            /* blocks in motion for which the candidate has held */
    uint16_t       rejected;            /* blocks of rejection; falls twice as fast afterwards */
    uint16_t       settling;            /* blocks until rejection begins */
    uint16_t       correct_q21;         /* the heading's gain: of the configuration, raised; or 0 */
    int16_t        turn_q21;            /* correction of the heading, half angle */
    uint16_t       turn_res;            /* carry of the heading's correction */
    uint8_t        phase;               /* sample of this block, 0..MAHONY_MAG_BLOCK - 1 */
    bool           refused;             /* the block before has no heading */
    bool           whole;               /* there is a block before */
    bool           started;             /* heading and reference are set */
} mahony_mag_t;

typedef struct {
    const mahony_config_t *config;
    mahony_step_t          step;
    int32_t                integral_q22[3]; /* bias by ki, gyr LSB, |.| <= 328 LSB (20 deg/s) */
    uint16_t               integral_res;
    uint16_t               ramp_left; /* blocks until gains are one */
    bool                   started;   /* attitude is set */
    bool                   usual;     /* nothing to do but a step: see mahony_update */
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

#endif

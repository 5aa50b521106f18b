/* SPDX-License-Identifier: MIT */
/* ins_blocks - error-state Kalman filter of a strapdown inertial navigator, over arrays.
 *
 * Purpose   foot-mounted and other walks on the host: the only part that is too slow in numpy.
 * Model     errors (truth less estimate) of position, velocity, attitude (a turn of the world),
 *           bias of gyroscope and accelerometer; with 24 states also their scales and gravity.
 *           Closed loop: estimates take the errors up after each update. Pseudo-measurements:
 *           velocity is zero (world axes), angular rate is zero (body axes), a foot stands at the
 *           height where it stood before; each scalar by scalar in Joseph's form. Smoother:
 *           Bryson and Frazier's, modified (Bierman 1973): adjoint states run backward, no matrix
 *           is inverted.
 * Formats   float64; m, m/s, rad, rad/s, m/s^2; world axes z up; quat_wb body to world, scalar
 *           first; vectors of a sample lie one behind the other.
 * Bad data  no check here: the caller gives finite values and positive sigmas.
 * Context   one caller a state; no heap: the smoother's tape is the caller's.
 */
#ifndef INS_BLOCKS_H
#define INS_BLOCKS_H

#include <stddef.h>
#include <stdint.h>

#define INS_STATES_MAX 24

/* Blocks of three states each, in this order: position, velocity, attitude, bias of the gyroscope,
 * bias of the accelerometer, scale of the gyroscope, scale of the accelerometer, gravity. */
typedef struct {
    double   pos_w_m[3];
    double   vel_w_m_s[3];
    double   quat_wb[4];
    double   gyro_bias_rad_s[3];
    double   acc_bias_m_s2[3];
    double   gyro_scale[3]; /* share of the rate that is too much */
    double   acc_scale[3];
    double   gravity_w_m_s2[3];
    double   noise_per_s[8]; /* variance that a block gains in a second, by its unit squared */
    double   cov[576];       /* states x states, row by row */
    uint32_t states;         /* 15 or 24 */
    uint32_t clipped;        /* updates that the gate made smaller */
    double   gate_sigmas;    /* an innovation beyond so many sigmas counts less; 0: never */
    double   level_w_m;      /* height of the floor that holds */
    double   level_gate_m;   /* a foot that stands farther from it stands on another floor */
    uint32_t levels;         /* floors so far; 0: level_w_m does not hold yet */
} ins_t;

/* What one sample leaves behind for the smoother. */
typedef struct {
    double   pos_w_m[3];
    double   vel_w_m_s[3];
    double   quat_wb[4];
    double   cov[576];        /* after the updates */
    double   matrix_wb[9];    /* half way through the sample */
    double   acc_w_m_s2[3];   /* specific force */
    double   acc_b_m_s2[3];   /* as measured, for the scales */
    double   gyro_b_rad_s[3]; /* likewise */
    double   dt_s;            /* length of the sample */
    double   gain[168];       /* scalars x states */
    double   share[7];        /* innovation over its variance */
    uint32_t state[7];        /* which state each scalar saw */
    uint32_t scalars;         /* how many there were */
} ins_tape_t;

/* One sample each: dt_s since the one before, specific force, angular rate. The sigmas are those of
 * the three pseudo-measurements at this sample; zero or less: none.  path: (count, 10) position,
 * velocity, quat_wb;  bias: (count, 6) gyroscope, accelerometer; may be NULL.
 * tape: NULL, or room for count samples. */
void ins_blocks_run(ins_t *ins, const double dt_s[], const double acc_b_m_s2[],
                    const double gyro_b_rad_s[], const double vel_sigma_m_s[],
                    const double rate_sigma_rad_s[], const double level_sigma_m[], double path[],
                    double *bias, ins_tape_t *tape, size_t count);

/* Backward over a tape: writes the smoothed (kept, 10) path of its first `kept` samples, as seen
 * from the end of all `count` of them. */
void ins_blocks_smooth(const ins_tape_t tape[], size_t count, size_t kept, uint32_t states,
                       double path[]);

#endif

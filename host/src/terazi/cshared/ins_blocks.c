/* SPDX-License-Identifier: MIT */
#include "ins_blocks.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { POS = 0, VEL = 3, ATT = 6, GYRO_BIAS = 9, ACC_BIAS = 12, BASIC = 15 };
enum { GYRO_SCALE = 15, ACC_SCALE = 18, GRAVITY = 21, PATH = 10 };

static void quat_turn_b(double quat[4], const double angle_b[3]) /* quat (x) turn */
{
    const double norm = sqrt(angle_b[0] * angle_b[0] + angle_b[1] * angle_b[1] +
                             angle_b[2] * angle_b[2]);
    /* sin(x / 2) / x: below 1e-4 rad the series is exact to 1e-17 */
    const double sinc = norm > 1e-4 ? sin(norm / 2.0) / norm : 0.5 - norm * norm / 48.0;
    const double w = cos(norm / 2.0), x = sinc * angle_b[0], y = sinc * angle_b[1],
                 z = sinc * angle_b[2];
    const double a = quat[0], b = quat[1], c = quat[2], d = quat[3];

    quat[0] = a * w - b * x - c * y - d * z;
    quat[1] = a * x + b * w + c * z - d * y;
    quat[2] = a * y - b * z + c * w + d * x;
    quat[3] = a * z + b * y - c * x + d * w;
}

static void quat_turn_w(double quat[4], const double angle_w[3]) /* turn (x) quat */
{
    /* q (x) p = conj(conj(p) (x) conj(q)): one product does for both sides. */
    const double back[3]  = {-angle_w[0], -angle_w[1], -angle_w[2]};
    double       other[4] = {quat[0], -quat[1], -quat[2], -quat[3]};
    double       norm     = 0.0;

    quat_turn_b(other, back);
    for (size_t i = 0U; i < 4U; ++i) { norm += other[i] * other[i]; }
    norm    = sqrt(norm);
    quat[0] = other[0] / norm;
    for (size_t i = 1U; i < 4U; ++i) { quat[i] = -other[i] / norm; }
}

static void matrix_of(const double q[4], double matrix[9])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];

    matrix[0] = 1.0 - 2.0 * (y * y + z * z);
    matrix[1] = 2.0 * (x * y - w * z);
    matrix[2] = 2.0 * (x * z + w * y);
    matrix[3] = 2.0 * (x * y + w * z);
    matrix[4] = 1.0 - 2.0 * (x * x + z * z);
    matrix[5] = 2.0 * (y * z - w * x);
    matrix[6] = 2.0 * (x * z - w * y);
    matrix[7] = 2.0 * (y * z + w * x);
    matrix[8] = 1.0 - 2.0 * (x * x + y * y);
}

/* The transition's blocks off the diagonal; all others are zero. */
typedef struct {
    double vel_by_att[9];
    double by_bias[9];      /* velocity by accelerometer bias, attitude by gyroscope bias */
    double vel_by_scale[9]; /* by_bias, each column by its acceleration */
    double att_by_scale[9]; /* by_bias, each column by its rate */
    double dt_s;
} transition_t;

static transition_t transition_of(const double matrix[9], const double acc_w[3],
                                  const double acc_b[3], const double gyro_b[3], double dt_s)
{
    const double x = acc_w[0] * dt_s, y = acc_w[1] * dt_s, z = acc_w[2] * dt_s;
    transition_t t = {.vel_by_att = {0.0, z, -y, -z, 0.0, x, y, -x, 0.0}, .dt_s = dt_s};

    for (size_t i = 0U; i < 9U; ++i) {
        t.by_bias[i]      = -matrix[i] * dt_s;
        t.vel_by_scale[i] = t.by_bias[i] * acc_b[i % 3U];
        t.att_by_scale[i] = t.by_bias[i] * gyro_b[i % 3U];
    }
    return t;
}

/* to += block * from, for three rows of a matrix that is `width` wide. */
static void add_rows(double *matrix, size_t to, size_t from, const double block[9], size_t width)
{
    for (size_t i = 0U; i < 3U; ++i) {
        const double        a = block[3U * i], b = block[3U * i + 1U], c = block[3U * i + 2U];
        double *const       target = &matrix[(to + i) * width];
        const double *const source = &matrix[from * width];

        for (size_t k = 0U; k < width; ++k) {
            target[k] += a * source[k] + b * source[width + k] + c * source[2U * width + k];
        }
    }
}

static void add_scaled_rows(double *matrix, size_t to, size_t from, double scale, size_t width)
{
    for (size_t k = 0U; k < 3U * width; ++k) {
        matrix[to * width + k] += scale * matrix[from * width + k];
    }
}

/* matrix = Phi * matrix, in place: a block is written only after all that read its old value. */
static void apply_rows(double *matrix, const transition_t *t, size_t width, bool all)
{
    add_scaled_rows(matrix, POS, VEL, t->dt_s, width);
    add_rows(matrix, VEL, ATT, t->vel_by_att, width);
    add_rows(matrix, VEL, ACC_BIAS, t->by_bias, width);
    if (all) {
        add_rows(matrix, VEL, ACC_SCALE, t->vel_by_scale, width);
        add_scaled_rows(matrix, VEL, GRAVITY, t->dt_s, width);
        add_rows(matrix, ATT, GYRO_SCALE, t->att_by_scale, width);
    }
    add_rows(matrix, ATT, GYRO_BIAS, t->by_bias, width);
}

static void transpose(double *matrix, size_t n)
{
    for (size_t i = 0U; i < n; ++i) {
        for (size_t k = 0U; k < i; ++k) {
            const double kept = matrix[i * n + k];

            matrix[i * n + k] = matrix[k * n + i];
            matrix[k * n + i] = kept;
        }
    }
}

/* cov = Phi cov Phi^T + Q: the rows twice, with a transposition between. */
static void propagate_cov(ins_t *ins, const transition_t *t)
{
    const size_t n   = ins->states;
    const bool   all = n > BASIC;

    apply_rows(ins->cov, t, n, all);
    transpose(ins->cov, n);
    apply_rows(ins->cov, t, n, all);
    for (size_t i = 0U; i < n; ++i) { ins->cov[i * n + i] += ins->noise_per_s[i / 3U] * t->dt_s; }
}

static void propagate(ins_t *ins, double dt_s, const double acc_b[3], const double gyro_b[3],
                      ins_tape_t *left)
{
    double half_turn_b[3], force_b[3], force_w[3], matrix[9], motion_w[3];

    for (size_t i = 0U; i < 3U; ++i) {
        half_turn_b[i] = 0.5 * dt_s *
                         (gyro_b[i] * (1.0 - ins->gyro_scale[i]) - ins->gyro_bias_rad_s[i]);
        force_b[i] = acc_b[i] * (1.0 - ins->acc_scale[i]) - ins->acc_bias_m_s2[i];
    }
    quat_turn_b(ins->quat_wb, half_turn_b);
    matrix_of(ins->quat_wb, matrix);
    quat_turn_b(ins->quat_wb, half_turn_b);
    for (size_t i = 0U; i < 3U; ++i) {
        force_w[i] = matrix[3U * i] * force_b[0] + matrix[3U * i + 1U] * force_b[1] +
                     matrix[3U * i + 2U] * force_b[2];
        motion_w[i] = force_w[i] + ins->gravity_w_m_s2[i];
        ins->pos_w_m[i] += dt_s * (ins->vel_w_m_s[i] + 0.5 * dt_s * motion_w[i]);
        ins->vel_w_m_s[i] += dt_s * motion_w[i];
    }
    const transition_t t = transition_of(matrix, force_w, acc_b, gyro_b, dt_s);

    propagate_cov(ins, &t);
    if (left != NULL) {
        memcpy(left->matrix_wb, matrix, sizeof matrix);
        memcpy(left->acc_w_m_s2, force_w, sizeof force_w);
        memcpy(left->acc_b_m_s2, acc_b, sizeof force_b);
        memcpy(left->gyro_b_rad_s, gyro_b, sizeof force_b);
        left->dt_s    = dt_s;
        left->scalars = 0U;
    }
}

/* One scalar sees one state: cov = (I - K h) cov (I - K h)^T + K r K^T, h the row of that state. */
static void update_scalar(ins_t *ins, size_t state, double innovation, double variance,
                          double error[], ins_tape_t *left)
{
    const size_t n   = ins->states;
    double      *cov = ins->cov;
    double       gain[INS_STATES_MAX], row[INS_STATES_MAX];

    innovation -= error[state];
    double total = cov[state * n + state] + variance;
    if (ins->gate_sigmas > 0.0) {
        /* Huber's weight by way of the variance: what lies beyond the gate pulls as if on it. */
        const double over = fabs(innovation) / (ins->gate_sigmas * sqrt(total));

        if (over > 1.0) {
            variance += total * (over - 1.0);
            total *= over;
            ++ins->clipped;
        }
    }
    for (size_t i = 0U; i < n; ++i) {
        gain[i] = cov[i * n + state] / total;
        row[i]  = cov[state * n + i];
    }
    for (size_t i = 0U; i < n; ++i) {
        for (size_t k = 0U; k < n; ++k) { cov[i * n + k] -= gain[i] * row[k]; }
    }
    for (size_t i = 0U; i < n; ++i) {
        const double seen = cov[i * n + state] - gain[i] * variance;

        for (size_t k = 0U; k < n; ++k) { cov[i * n + k] -= seen * gain[k]; }
        error[i] += gain[i] * innovation;
    }
    if (left != NULL) {
        const size_t at = left->scalars++;

        memcpy(&left->gain[at * INS_STATES_MAX], gain, n * sizeof gain[0]);
        left->share[at] = innovation / total;
        left->state[at] = (uint32_t)state;
    }
}

static void take_up(ins_t *ins, const double error[])
{
    for (size_t i = 0U; i < 3U; ++i) {
        ins->pos_w_m[i] += error[POS + i];
        ins->vel_w_m_s[i] += error[VEL + i];
        ins->gyro_bias_rad_s[i] += error[GYRO_BIAS + i];
        ins->acc_bias_m_s2[i] += error[ACC_BIAS + i];
        if (ins->states > BASIC) {
            ins->gyro_scale[i] += error[GYRO_SCALE + i];
            ins->acc_scale[i] += error[ACC_SCALE + i];
            ins->gravity_w_m_s2[i] += error[GRAVITY + i];
        }
    }
    quat_turn_w(ins->quat_wb, &error[ATT]);
}

static void update(ins_t *ins, const double gyro_b[3], double vel_sigma, double rate_sigma,
                   double level_sigma, ins_tape_t *left)
{
    double error[INS_STATES_MAX] = {0.0};

    if (vel_sigma > 0.0) {
        for (size_t i = 0U; i < 3U; ++i) {
            update_scalar(ins, VEL + i, -ins->vel_w_m_s[i], vel_sigma * vel_sigma, error, left);
        }
    }
    if (rate_sigma > 0.0) {
        for (size_t i = 0U; i < 3U; ++i) {
            const double rate = gyro_b[i] * (1.0 - ins->gyro_scale[i]) - ins->gyro_bias_rad_s[i];

            update_scalar(ins, GYRO_BIAS + i, rate, rate_sigma * rate_sigma, error, left);
        }
    }
    if (level_sigma > 0.0) {
        const double below = ins->level_w_m - ins->pos_w_m[2];

        if (ins->levels > 0U && fabs(below) <= ins->level_gate_m) {
            update_scalar(ins, POS + 2U, below, level_sigma * level_sigma, error, left);
        } else {
            ins->level_w_m = ins->pos_w_m[2];
            ++ins->levels;
        }
    }
    if (vel_sigma > 0.0 || rate_sigma > 0.0 || level_sigma > 0.0) { take_up(ins, error); }
}

void ins_blocks_run(ins_t *ins, const double dt_s[], const double acc_b_m_s2[],
                    const double gyro_b_rad_s[], const double vel_sigma_m_s[],
                    const double rate_sigma_rad_s[], const double level_sigma_m[], double path[],
                    double *bias, ins_tape_t *tape, size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        ins_tape_t *const left = tape == NULL ? NULL : &tape[at];
        double *const     row  = &path[PATH * at];

        propagate(ins, dt_s[at], &acc_b_m_s2[3U * at], &gyro_b_rad_s[3U * at], left);
        update(ins, &gyro_b_rad_s[3U * at], vel_sigma_m_s[at], rate_sigma_rad_s[at],
               level_sigma_m[at], left);
        memcpy(&row[0], ins->pos_w_m, sizeof ins->pos_w_m);
        memcpy(&row[3], ins->vel_w_m_s, sizeof ins->vel_w_m_s);
        memcpy(&row[6], ins->quat_wb, sizeof ins->quat_wb);
        if (bias != NULL) {
            memcpy(&bias[6U * at], ins->gyro_bias_rad_s, sizeof ins->gyro_bias_rad_s);
            memcpy(&bias[6U * at + 3U], ins->acc_bias_m_s2, sizeof ins->acc_bias_m_s2);
        }
        if (left != NULL) {
            memcpy(left->pos_w_m, ins->pos_w_m, sizeof ins->pos_w_m);
            memcpy(left->vel_w_m_s, ins->vel_w_m_s, sizeof ins->vel_w_m_s);
            memcpy(left->quat_wb, ins->quat_wb, sizeof ins->quat_wb);
            memcpy(left->cov, ins->cov, ins->states * ins->states * sizeof ins->cov[0]);
        }
    }
}

/* adjoint[of] += block^T adjoint[by] */
static void add_back(double adjoint[], size_t of, size_t by, const double block[9])
{
    for (size_t i = 0U; i < 9U; ++i) { adjoint[of + i % 3U] += block[i] * adjoint[by + i / 3U]; }
}

static void adjoint_back(double adjoint[], const ins_tape_t *left, size_t n)
{
    for (size_t at = left->scalars; at-- > 0U;) {
        const double *const gain = &left->gain[at * INS_STATES_MAX];
        double              seen = left->share[at];

        for (size_t i = 0U; i < n; ++i) { seen += gain[i] * adjoint[i]; }
        adjoint[left->state[at]] -= seen;
    }
    const transition_t t = transition_of(left->matrix_wb, left->acc_w_m_s2, left->acc_b_m_s2,
                                         left->gyro_b_rad_s, left->dt_s);

    if (n > BASIC) {
        add_back(adjoint, GYRO_SCALE, ATT, t.att_by_scale);
        add_back(adjoint, ACC_SCALE, VEL, t.vel_by_scale);
        for (size_t i = 0U; i < 3U; ++i) { adjoint[GRAVITY + i] += t.dt_s * adjoint[VEL + i]; }
    }
    add_back(adjoint, GYRO_BIAS, ATT, t.by_bias);
    add_back(adjoint, ACC_BIAS, VEL, t.by_bias);
    add_back(adjoint, ATT, VEL, t.vel_by_att);
    for (size_t i = 0U; i < 3U; ++i) { adjoint[VEL + i] += t.dt_s * adjoint[POS + i]; }
}

void ins_blocks_smooth(const ins_tape_t tape[], size_t count, size_t kept, uint32_t states,
                       double path[])
{
    const size_t n                       = states;
    double       adjoint[INS_STATES_MAX] = {0.0};

    for (size_t at = count; at-- > 0U;) {
        const ins_tape_t *const left = &tape[at];

        if (at < kept) {
            double *const row          = &path[PATH * at];
            double        error[BASIC] = {0.0};

            for (size_t i = 0U; i < GYRO_BIAS; ++i) {
                for (size_t k = 0U; k < n; ++k) { error[i] -= left->cov[i * n + k] * adjoint[k]; }
            }
            memcpy(&row[6], left->quat_wb, sizeof left->quat_wb);
            quat_turn_w(&row[6], &error[ATT]);
            for (size_t i = 0U; i < 3U; ++i) {
                row[i]      = left->pos_w_m[i] + error[POS + i];
                row[3U + i] = left->vel_w_m_s[i] + error[VEL + i];
            }
        }
        adjoint_back(adjoint, left, n);
    }
}

/* SPDX-License-Identifier: MIT */
#include "weight_kf_adaptive.h"

#include "fixed.h"
#include "port_assert.h"
#include "port_fixed.h"
#include "port_weight_kf_adaptive.h"
#include "weight_kf_adaptive_variants.h"

/* The law's numbers, as the shifts below have them. */
_Static_assert(WEIGHT_KF_ADAPTIVE_JUMP_FROM_SIGMAS == 3 && WEIGHT_KF_ADAPTIVE_REOPEN_SIGMAS == 8 &&
                   WEIGHT_KF_ADAPTIVE_LIMIT_SIGMAS == 4 && WEIGHT_KF_ADAPTIVE_LEARN_SHIFT == 8 &&
                   WEIGHT_KF_ADAPTIVE_LEARN_FROM_SIGMAS == 1 &&
                   WEIGHT_KF_ADAPTIVE_LEARN_CAP_SIGMAS == 4,
               "[law] in weight_kf_adaptive.toml");
_Static_assert(WEIGHT_KF_ADAPTIVE_MOVING_FROM_SIGMAS == 6 && WEIGHT_KF_ADAPTIVE_MOVING_SHIFT == 1 &&
                   WEIGHT_KF_ADAPTIVE_MOVING_QUIET_SIGMAS == 3 &&
                   WEIGHT_KF_ADAPTIVE_MOVING_LEARN_SHIFT == 11 &&
                   WEIGHT_KF_ADAPTIVE_SAME_LOAD_SIGMAS == 2,
               "[law] in weight_kf_adaptive.toml");

#define ROOT_HALF_PI_Q9 642U   /* a normal deviate's sigma over its mean magnitude */
#define NOISE_MIN_Q8    256U   /* one count */
#define NOISE_MAX_Q8    32767U /* twice its square stays below 2^31 */

static uint16_t noise_q8(const weight_kf_adaptive_t *kf)
{
    return (uint16_t)(kf->noise_q16 >> 8);
}

static void remember(weight_kf_adaptive_t *kf, int32_t z_q7)
{
    kf->before_counts_q7[1] = kf->before_counts_q7[0];
    kf->before_counts_q7[0] = z_q7;
}

void weight_kf_adaptive_init(weight_kf_adaptive_t *kf, const weight_kf_adaptive_config_t *config,
                             int32_t first_counts)
{
    PORT_ASSERT(config->noise_min_q8 >= NOISE_MIN_Q8 && config->noise_max_q8 <= NOISE_MAX_Q8);

    kf->config             = config;
    kf->clipped            = 0U;
    kf->fraction_q23       = 0U;
    kf->estimate_counts_q7 = port_to_q7(fixed_clamp_counts(first_counts, &kf->clipped));
    kf->noise_q16          = (uint32_t)config->noise_q8 << 8;
    kf->var_q16            = port_mul_u16(config->noise_q8, config->noise_q8);
    remember(kf, kf->estimate_counts_q7);
    remember(kf, kf->estimate_counts_q7);
}

int32_t weight_kf_adaptive_update(weight_kf_adaptive_t *kf, int32_t measured_counts)
{
    return port_weight_kf_adaptive_step(kf, fixed_clamp_counts(measured_counts, &kf->clipped),
                                        WEIGHT_KF_ADAPTIVE_JUMP_FROM_SIGMAS);
}

#include "port_hot.h"

void weight_kf_adaptive_pair_init(weight_kf_adaptive_pair_t         *pair,
                                  const weight_kf_adaptive_config_t *config, int32_t first_counts)
{
    weight_kf_adaptive_init(&pair->rest, config, first_counts);
    pair->moving_counts_q7 = pair->rest.estimate_counts_q7;
    pair->quiet            = 0U;
    pair->moving           = false;
}

static int32_t apart_q7(int32_t a_q7, int32_t b_q7)
{
    return a_q7 < b_q7 ? b_q7 - a_q7 : a_q7 - b_q7;
}

/* Whether value, on the side of z and seen from the estimate, lies beyond the margin. */
static bool is_beyond(int32_t value_q7, int32_t estimate_q7, int32_t margin_q7, bool is_below)
{
    return (is_below ? estimate_q7 - value_q7 : value_q7 - estimate_q7) > margin_q7;
}

/* Whether all of the last three lie 6 sigma from the estimate, on one side. */
__attribute__((noinline)) static bool has_moved(const weight_kf_adaptive_t *rest, int32_t z_q7)
{
    const int32_t x_q7      = rest->estimate_counts_q7;
    const int32_t margin_q7 = 3 * (int32_t)noise_q8(rest);
    const bool    is_below  = z_q7 < x_q7;

    return is_beyond(z_q7, x_q7, margin_q7, is_below) &&
           is_beyond(rest->before_counts_q7[0], x_q7, margin_q7, is_below) &&
           is_beyond(rest->before_counts_q7[1], x_q7, margin_q7, is_below);
}

/* The noise while the load moves: as at rest, but 8 times slower. */
static void learn_slowly(weight_kf_adaptive_t *rest, int32_t size_q7)
{
    const weight_kf_adaptive_config_t *config     = rest->config;
    const int32_t                      sigma_q8   = noise_q8(rest);
    const int32_t                      cap_q7     = 2 * sigma_q8; /* 4 sigma */
    const uint16_t                     left_q7    = (uint16_t)(size_q7 < cap_q7 ? size_q7 : cap_q7);
    const int32_t                      taught_q16 = (int32_t)port_mul_u16(left_q7, ROOT_HALF_PI_Q9);
    const int32_t                      surplus_q16 = taught_q16 - (int32_t)rest->noise_q16;

    rest->noise_q16 += (uint32_t)((surplus_q16 + (1 << 10)) >> 11);
    if (noise_q8(rest) < config->noise_min_q8) {
        rest->noise_q16 = (uint32_t)config->noise_min_q8 << 8;
    } else if (noise_q8(rest) >= config->noise_max_q8) {
        rest->noise_q16 = (uint32_t)config->noise_max_q8 << 8;
    }
}

/* One more innovation of the moving model: is it time to rest? */
__attribute__((noinline)) static void follow(weight_kf_adaptive_pair_t *pair, int32_t size_q7)
{
    weight_kf_adaptive_t *rest     = &pair->rest;
    const int32_t         sigma_q8 = noise_q8(rest);

    pair->quiet = size_q7 < sigma_q8 + (sigma_q8 >> 1) ? (uint8_t)(pair->quiet + 1U)
                                                       : 0U; /* 3 sigma */
    if (pair->quiet == WEIGHT_KF_ADAPTIVE_MOVING_QUIET_SAMPLES) {
        pair->moving = false;
        remember(rest, pair->moving_counts_q7);
        remember(rest, pair->moving_counts_q7);
        if (apart_q7(pair->moving_counts_q7, rest->estimate_counts_q7) > sigma_q8) { /* 2 sigma */
            rest->estimate_counts_q7 = pair->moving_counts_q7;
            rest->fraction_q23       = 0U;
            rest->var_q16 = port_mul_u16((uint16_t)sigma_q8, (uint16_t)sigma_q8) >> 1; /* R / 2 */
        }
    }
    learn_slowly(rest, size_q7);
}

int32_t weight_kf_adaptive_pair_update(weight_kf_adaptive_pair_t *pair, int32_t measured_counts)
{
    weight_kf_adaptive_t *rest      = &pair->rest;
    const int32_t         counts    = fixed_clamp_counts(measured_counts, &rest->clipped);
    const int32_t         z_q7      = fixed_counts_q7(counts);
    const int32_t         before_q7 = pair->moving_counts_q7;

    pair->moving_counts_q7 += (z_q7 - before_q7 + 1) >> 1; /* |.| < 2^31 */
    if (pair->moving) {
        follow(pair, apart_q7(z_q7, before_q7));
        return pair->moving ? pair->moving_counts_q7 : rest->estimate_counts_q7;
    }
    if (has_moved(rest, z_q7)) {
        pair->moving           = true;
        pair->quiet            = 0U;
        pair->moving_counts_q7 = z_q7;
        return z_q7;
    }
    /* Nothing lies beyond this margin, or it would have moved: no jump. */
    return port_weight_kf_adaptive_step(rest, counts, WEIGHT_KF_ADAPTIVE_MOVING_FROM_SIGMAS);
}

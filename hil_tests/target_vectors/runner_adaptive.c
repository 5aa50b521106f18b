/* SPDX-License-Identifier: MIT */
#include "runner_adaptive.h"

#include "weight_kf_adaptive.h"
#include "weight_kf_adaptive_variants.h"

#include <string.h>

static const weight_kf_adaptive_config_t *const configs[] = {
    [WEIGHT_KF_ADAPTIVE_VARIANT_DEFAULT]     = &weight_kf_adaptive_default,
    [WEIGHT_KF_ADAPTIVE_VARIANT_KNOWN_NOISE] = &weight_kf_adaptive_known_noise,
};

static weight_kf_adaptive_pair_t pair; /* its resting filter serves alone, too */

static uint8_t update(uint8_t op, uint8_t buffer[], uint8_t len)
{
    for (uint8_t at = 0; at < len; at = (uint8_t)(at + 4U)) {
        int32_t counts;
        memcpy(&counts, &buffer[at], sizeof counts);
        counts = op == OP_PAIR_UPDATE ? weight_kf_adaptive_pair_update(&pair, counts)
                                      : weight_kf_adaptive_update(&pair.rest, counts);
        memcpy(&buffer[at], &counts, sizeof counts);
    }
    return len;
}

uint8_t runner_adaptive_serve(uint8_t op, uint8_t buffer[], uint8_t len)
{
    int32_t first;

    switch (op) {
    case OP_ADAPTIVE_UPDATE:
    case OP_PAIR_UPDATE: return update(op, buffer, len);
    case OP_ADAPTIVE_CLIP: memcpy(buffer, &pair.rest.clipped, sizeof pair.rest.clipped); return 2;
    default:
        memcpy(&first, &buffer[1], sizeof first);
        if (op == OP_PAIR_INIT) {
            weight_kf_adaptive_pair_init(&pair, configs[buffer[0]], first);
        } else {
            weight_kf_adaptive_init(&pair.rest, configs[buffer[0]], first);
        }
        return 0;
    }
}

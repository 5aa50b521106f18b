/* SPDX-License-Identifier: MIT */
/* The offsets that port_weight_kf.S writes by hand. */
#include <stddef.h>

#include "weight_kf.h"

_Static_assert(offsetof(weight_kf_t, config) == 0 &&
                   offsetof(weight_kf_t, estimate_counts_q7) == 2 &&
                   offsetof(weight_kf_t, step) == 6 && offsetof(weight_kf_t, clipped) == 7,
               "KF_ in port_weight_kf.S");
_Static_assert(offsetof(weight_kf_config_t, gain_q15) == 0 &&
                   offsetof(weight_kf_config_t, gain_len) == 2,
               "the config's fields in port_weight_kf.S");

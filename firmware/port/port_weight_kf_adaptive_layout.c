/* SPDX-License-Identifier: MIT */
/* The offsets that port_weight_kf_adaptive.S writes by hand. */
#include <stddef.h>

#include "weight_kf_adaptive.h"

_Static_assert(offsetof(weight_kf_adaptive_t, config) == 0 &&
                   offsetof(weight_kf_adaptive_t, estimate_counts_q7) == 2 &&
                   offsetof(weight_kf_adaptive_t, var_q16) == 6 &&
                   offsetof(weight_kf_adaptive_t, noise_q16) == 10 &&
                   offsetof(weight_kf_adaptive_t, before_counts_q7) == 14 &&
                   offsetof(weight_kf_adaptive_t, fraction_q23) == 22,
               "KF_ in port_weight_kf_adaptive.S");
_Static_assert(offsetof(weight_kf_adaptive_config_t, process_var_q16) == 0 &&
                   offsetof(weight_kf_adaptive_config_t, noise_min_q8) == 4 &&
                   offsetof(weight_kf_adaptive_config_t, noise_max_q8) == 6,
               "CONFIG_ in port_weight_kf_adaptive.S");

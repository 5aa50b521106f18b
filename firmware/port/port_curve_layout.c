/* SPDX-License-Identifier: MIT */
/* The offsets that port_curve.S writes by hand. */
#include <stddef.h>

#include "scale.h"

_Static_assert(offsetof(scale_t, config) == 0 && offsetof(scale_t, falling) == 5 &&
                   offsetof(scale_t, slope_q32) == 91,
               "SCALE_ in port_curve.S");
_Static_assert(offsetof(scale_config_t, points) == 28 &&
                   offsetof(scale_config_t, point_counts_q7) == 36 &&
                   offsetof(scale_config_t, point_mass_mg) == 68,
               "CONFIG_ in port_curve.S");

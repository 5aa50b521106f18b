/* SPDX-License-Identifier: MIT */
/* The offsets that port_watch.S writes by hand. */
#include <stddef.h>

#include "scale.h"

_Static_assert(offsetof(scale_t, begun) == 6 && offsetof(scale_t, steady) == 7 &&
                   offsetof(scale_t, grain) == 9 && offsetof(scale_t, band) == 10 &&
                   offsetof(scale_t, anchor_q7) == 11,
               "SCALE_ in port_watch.S");
_Static_assert(offsetof(scale_t, low) == 15 && offsetof(scale_t, high) == 17 &&
                   offsetof(scale_t, raw) == 19 && offsetof(scale_t, rough_q4) == 21 &&
                   offsetof(scale_t, lag_q3) == 23,
               "SCALE_ in port_watch.S");

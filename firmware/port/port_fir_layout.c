/* SPDX-License-Identifier: MIT */
/* The offsets that port_fir.S writes by hand. */
#include <stddef.h>

#include "fir.h"

_Static_assert(offsetof(fir_config_t, half_q15) == 0 && offsetof(fir_config_t, taps) == 2 &&
                   offsetof(fir_config_t, loaded) == 3,
               "CONFIG_ in port_fir.S");
_Static_assert(offsetof(fir_t, config) == 0 && offsetof(fir_t, next) == 4 &&
                   offsetof(fir_t, window) == 5,
               "FIR_ in port_fir.S");

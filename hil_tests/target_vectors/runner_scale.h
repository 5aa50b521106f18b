/* SPDX-License-Identifier: MIT */
/* runner_scale - the runner's requests for scale. */
#ifndef RUNNER_SCALE_H
#define RUNNER_SCALE_H

#include <stdint.h>

/* Do what was asked with the payload in the buffer; gives the length of the reply there. */
uint8_t runner_scale_serve(uint8_t buffer[], uint8_t len);

#endif

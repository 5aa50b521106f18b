/* SPDX-License-Identifier: MIT */
/* runner_mahony - the runner's requests for mahony: ops 0..9. */
#ifndef RUNNER_MAHONY_H
#define RUNNER_MAHONY_H

#include <stdint.h>

/* Do what was asked with the payload in the buffer; gives the length of the reply there. */
uint8_t runner_mahony_serve(uint8_t op, uint8_t buffer[], uint8_t len);

#endif

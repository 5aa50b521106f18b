/* SPDX-License-Identifier: MIT */
/* runner - what serves requests in a runner; the wire is described in runner_main.c. */
#ifndef RUNNER_H
#define RUNNER_H

#include <stdint.h>

enum { RUNNER_REQUEST_MAX = 255 };

/* Do what was asked with the payload in the buffer; gives the length of the reply there. */
uint8_t runner_serve(uint8_t op, uint8_t buffer[], uint8_t len);

#endif

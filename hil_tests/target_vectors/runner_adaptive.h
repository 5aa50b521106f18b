/* SPDX-License-Identifier: MIT */
/* runner_adaptive - the runner's requests for weight_kf_adaptive. */
#ifndef RUNNER_ADAPTIVE_H
#define RUNNER_ADAPTIVE_H

#include <stdint.h>

enum {
    OP_ADAPTIVE_INIT   = 'u', /* variant u8, first i32 */
    OP_ADAPTIVE_UPDATE = 'U', /* n x measurement i32 -> n x estimate i32 */
    OP_PAIR_INIT       = 'v', /* variant u8, first i32 */
    OP_PAIR_UPDATE     = 'V', /* n x measurement i32 -> n x estimate i32 */
    OP_ADAPTIVE_CLIP   = 'w'  /* -> u16, of the one that was initialised last */
};

/* Do what was asked with the payload in the buffer; gives the length of the reply there. */
uint8_t runner_adaptive_serve(uint8_t op, uint8_t buffer[], uint8_t len);

#endif

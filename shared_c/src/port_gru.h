/* SPDX-License-Identifier: MIT */
/* port_gru - one gated recurrent unit (zupt_gru.h) in fixed point. Plain: port_plain/port_gru.c.
 * AVR: assembler.
 *
 * A sum is floor((256 bias + weights . seen + 128) / 256), in int16: whoever makes the weights sees
 * to that, and to |sum_n| + |sum_u| < 2^15, where both inputs are 10240 at most and states 2^13.
 */
#ifndef PORT_GRU_H
#define PORT_GRU_H

#include <stdint.h>

enum {
    PORT_GRU_GATES  = 3, /* reset r, update z, new n */
    PORT_GRU_INPUTS = 2,
    PORT_GRU_CELLS  = 8,
    PORT_GRU_SEEN   = PORT_GRU_INPUTS + PORT_GRU_CELLS,
    PORT_GRU_PIECES = 32 /* of the sigmoid */
};

/* In the order in which it is read. */
typedef struct {
    int16_t bias[PORT_GRU_GATES];
    int8_t  inputs[PORT_GRU_INPUTS][PORT_GRU_GATES];
    int16_t bias_u; /* of what n takes of the states, by r */
    int8_t  states[PORT_GRU_CELLS][PORT_GRU_GATES];
} port_gru_cell_t;

/* The unit's next state, from what it and all others were.  state is seen[2] or a later one.
 *     s(sum): sigmoid_q16 at |sum| / 512, straight between its points, both floors; 2^16 less that
 *             where sum < 0
 *     share(v, q16) = floor((v q16 + 2^15) / 2^16)
 *     n = floor((s(2 (sum_n + share(sum_u, s(sum_r)))) - 2^15) / 4), doubled to 32767 at most
 *     next = n + share(state - n, s(sum_z))
 * cell, sigmoid_q16: ROM; the latter rises from 2^15, at 0, to less than 2^16. */
int16_t port_gru_cell(const int16_t seen[PORT_GRU_SEEN], const port_gru_cell_t *cell,
                      const uint16_t sigmoid_q16[PORT_GRU_PIECES + 1], int16_t state);

#endif

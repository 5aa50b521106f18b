/* SPDX-License-Identifier: MIT */
/* port_gru - gated recurrent units (zupt_gru.h) in fixed point, and a logarithm for their inputs.
 * Plain: port_plain/port_gru.c. AVR: assembler.
 *
 * A sum is the bias and floor(weight * seen / 256) of each product, in int16: whoever makes the
 * weights sees to that, and to |sum_n| + |sum_u| < 2^15, where both inputs are 10240 at most and
 * states 2^13.
 */
#ifndef PORT_GRU_H
#define PORT_GRU_H

#include <stdint.h>

enum {
    PORT_GRU_GATES  = 3, /* reset r, update z, new n */
    PORT_GRU_INPUTS = 2,
    PORT_GRU_UNITS  = 8,
    PORT_GRU_SEEN   = PORT_GRU_INPUTS + PORT_GRU_UNITS,
    PORT_GRU_SPLIT = 3, /* units before it and from it on are two calls, of like time to zupt_gru */
    PORT_GRU_PIECES = 32 /* of the sigmoid, 256 each */
};

/* In the order in which it is read. */
typedef struct {
    int16_t bias[PORT_GRU_GATES];
    int8_t  inputs[PORT_GRU_INPUTS][PORT_GRU_GATES];
    int16_t bias_u; /* of what n takes of the states, by r */
    int8_t  states[PORT_GRU_UNITS][PORT_GRU_GATES];
} port_gru_unit_t;

/* ROM, of zupt_gru_weights.c: rises from 2^15, at 0, to less than 2^16. */
extern const uint16_t port_gru_sigmoid_q16[PORT_GRU_PIECES + 1];

/* Next states of the units before PORT_GRU_SPLIT (first 0) or from it on (first PORT_GRU_SPLIT):
 *     s(v): port_gru_sigmoid_q16 at |v| / 256, at its end where v is beyond, straight between its
 *           points, floor; 2^16 less that where v < 0
 *     share(v, q16) = floor((v q16 + 2^15) / 2^16)
 *     n = floor((s(sum_n + share(sum_u, s(floor(sum_r / 2)))) - 2^15) / 4)
 *     next = n + share(state - n, s(floor(sum_z / 2)))
 * units: ROM, from the first one on. */
void port_gru_units(int16_t next[], const int16_t seen[PORT_GRU_SEEN],
                    const port_gru_unit_t units[], uint8_t first);

/* A sum of the states.  weights: ROM */
int16_t port_gru_score(const int16_t states[PORT_GRU_UNITS], const int8_t weights[PORT_GRU_UNITS],
                       int16_t bias);

/* log2(number) in Q8: with number = 2^k (1 + f), f rounded down to 1/256, it is k + f + floor(88
 * floor(256 f (1 - f)) / 256) / 256, within 0.02 of the logarithm.  number > 0 */
int16_t port_gru_log2_q8(uint16_t number);

#endif

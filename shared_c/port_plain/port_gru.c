/* SPDX-License-Identifier: MIT */
/* port_gru - one gated recurrent unit. Plain: as src/port_gru.h says it. */
#include "port_gru.h"

#include "port_rom.h"

enum { HALF = 128, STEP_BITS = 9, SUM_MAX = 32767 };

/* Products of one gate's weights, a column of `weights`, with the first `count` of `seen`. */
static int32_t products(const int16_t seen[], const int8_t (*weights)[PORT_GRU_GATES], uint8_t gate,
                        uint8_t count)
{
    int32_t sum = 0;

    for (uint8_t n = 0U; n < count; ++n) {
        sum += (int32_t)seen[n] * (int8_t)port_rom_u8((const uint8_t *)&weights[n][gate]);
    }
    return sum;
}

static int16_t rounded(int32_t sum, const int16_t *bias)
{
    return (int16_t)((sum + (int32_t)port_rom_i16(bias) * 256 + HALF) >> 8);
}

static uint16_t sigmoid(const uint16_t sigmoid_q16[], int32_t sum)
{
    const int32_t  size  = sum < 0 ? -sum : sum;
    const uint16_t at    = (uint16_t)(size > SUM_MAX ? SUM_MAX : size);
    const uint8_t  piece = (uint8_t)(at >> STEP_BITS);
    const uint8_t  into  = (uint8_t)(at >> (STEP_BITS - 8));
    const uint16_t from  = port_rom_u16(&sigmoid_q16[piece]);
    const uint16_t rise  = (uint16_t)(port_rom_u16(&sigmoid_q16[piece + 1U]) - from);
    const uint16_t found = (uint16_t)(from + (((uint32_t)rise * into) >> 8));

    return sum < 0 ? (uint16_t)(0U - found) : found;
}

static int16_t share(int32_t value, uint16_t q16)
{
    return (int16_t)((value * q16 + 0x8000L) >> 16);
}

int16_t port_gru_cell(const int16_t seen[PORT_GRU_SEEN], const port_gru_cell_t *cell,
                      const uint16_t sigmoid_q16[PORT_GRU_PIECES + 1], int16_t state)
{
    int32_t sums[PORT_GRU_GATES];

    for (uint8_t gate = 0U; gate < PORT_GRU_GATES; ++gate) {
        sums[gate] = products(seen, cell->inputs, gate, PORT_GRU_INPUTS);
    }
    const int16_t *const states = &seen[PORT_GRU_INPUTS];
    for (uint8_t gate = 0U; gate < PORT_GRU_GATES - 1U; ++gate) {
        sums[gate] += products(states, cell->states, gate, PORT_GRU_CELLS);
    }
    const uint16_t reset  = sigmoid(sigmoid_q16, rounded(sums[0], &cell->bias[0]));
    const uint16_t update = sigmoid(sigmoid_q16, rounded(sums[1], &cell->bias[1]));
    const int16_t  sum_u  = rounded(products(states, cell->states, 2U, PORT_GRU_CELLS),
                                    &cell->bias_u);
    const int32_t  sum_n  = rounded(sums[2], &cell->bias[2]) + share(sum_u, reset);
    const int16_t  fresh  = (int16_t)((sigmoid(sigmoid_q16, 2 * sum_n) - 0x8000L) >> 2);

    return (int16_t)(fresh + share((int32_t)state - fresh, update));
}

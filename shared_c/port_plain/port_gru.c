/* SPDX-License-Identifier: MIT */
/* port_gru - gated recurrent units. Plain: as src/port_gru.h says it. */
#include "port_gru.h"

#include "port_rom.h"

enum { HALF = 128, VALUE_MAX = PORT_GRU_PIECES * 256 - 1, BULGE = 88, TEN = 10 << 8 };

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

static uint16_t sigmoid(int16_t value)
{
    const int32_t  size  = value < 0 ? -(int32_t)value : value;
    const uint16_t at    = (uint16_t)(size > VALUE_MAX ? VALUE_MAX : size);
    const uint8_t  piece = (uint8_t)(at >> 8);
    const uint16_t from  = port_rom_u16(&port_gru_sigmoid_q16[piece]);
    const uint16_t rise  = (uint16_t)(port_rom_u16(&port_gru_sigmoid_q16[piece + 1U]) - from);
    const uint16_t found = (uint16_t)(from + (((uint32_t)rise * (uint8_t)at) >> 8));

    return value < 0 ? (uint16_t)(0U - found) : found;
}

static int16_t share(int16_t value, uint16_t q16)
{
    return (int16_t)(((int32_t)value * q16 + 0x8000L) >> 16);
}

static int16_t unit(const int16_t seen[], const port_gru_unit_t *of, int16_t state)
{
    const int16_t *const states = &seen[PORT_GRU_INPUTS];
    int32_t              sums[PORT_GRU_GATES];

    for (uint8_t gate = 0U; gate < PORT_GRU_GATES; ++gate) {
        sums[gate] = products(seen, of->inputs, gate, PORT_GRU_INPUTS);
    }
    for (uint8_t gate = 0U; gate < PORT_GRU_GATES - 1U; ++gate) {
        sums[gate] += products(states, of->states, gate, PORT_GRU_UNITS);
    }
    const uint16_t reset  = sigmoid((int16_t)(rounded(sums[0], &of->bias[0]) >> 1));
    const uint16_t update = sigmoid((int16_t)(rounded(sums[1], &of->bias[1]) >> 1));
    const int16_t  sum_u  = rounded(products(states, of->states, 2U, PORT_GRU_UNITS), &of->bias_u);
    const int16_t  sum_n  = (int16_t)(rounded(sums[2], &of->bias[2]) + share(sum_u, reset));
    const int16_t  fresh  = (int16_t)((sigmoid(sum_n) - 0x8000L) >> 2);

    return (int16_t)(fresh + share((int16_t)(state - fresh), update));
}

void port_gru_units(int16_t next[], const int16_t seen[PORT_GRU_SEEN],
                    const port_gru_unit_t units[], uint8_t first)
{
    const uint8_t end = first == 0U ? PORT_GRU_SPLIT : PORT_GRU_UNITS;

    for (uint8_t n = first; n < end; ++n) {
        next[n - first] = unit(seen, &units[n - first], seen[PORT_GRU_INPUTS + n]);
    }
}

int16_t port_gru_score(const int16_t states[PORT_GRU_UNITS], const int8_t weights[PORT_GRU_UNITS],
                       int16_t bias)
{
    int32_t sum = (int32_t)bias * 256;

    for (uint8_t n = 0U; n < PORT_GRU_UNITS; ++n) {
        sum += (int32_t)states[n] * (int8_t)port_rom_u8((const uint8_t *)&weights[n]);
    }
    return (int16_t)(sum >> 8);
}

int16_t port_gru_octaves(uint16_t halves, uint16_t floor_q8)
{
    uint32_t number = halves;
    int32_t  log_q8 = 16L << 8;

    if (number == 0U) { return 0; }
    for (; number < 0x10000UL; number *= 2U) { log_q8 -= 1L << 8; }
    const uint32_t part = (number >> 8) & 0xFFU;
    log_q8 += (int32_t)(part + ((part * (256U - part) / 256U * BULGE) >> 8)) - floor_q8;
    if (log_q8 < 0) { return 0; }
    return (int16_t)(4 * (log_q8 < TEN ? log_q8 : TEN));
}

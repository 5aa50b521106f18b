/* SPDX-License-Identifier: MIT */
/* port_gru - gated recurrent units. Plain: as src/port_gru.h says it. */
#include "port_gru.h"

#include "port_rom.h"

enum { VALUE_MAX = PORT_GRU_PIECES * 256 - 1, BULGE = 88 };

/* floor(weight * seen / 256)  weight: ROM */
static int16_t product(const int8_t *weight, int16_t seen)
{
    return (int16_t)(((int32_t)seen * (int8_t)port_rom_u8((const uint8_t *)weight)) >> 8);
}

/* Of one gate's weights, a column of `weights`, with the first `count` of `seen`. */
static int16_t products(const int16_t seen[], const int8_t (*weights)[PORT_GRU_GATES], uint8_t gate,
                        uint8_t count)
{
    int16_t sum = 0;

    for (uint8_t n = 0U; n < count; ++n) {
        sum = (int16_t)(sum + product(&weights[n][gate], seen[n]));
    }
    return sum;
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
    int16_t              given[PORT_GRU_GATES], back[PORT_GRU_GATES];

    for (uint8_t gate = 0U; gate < PORT_GRU_GATES; ++gate) {
        given[gate] = (int16_t)(port_rom_i16(&of->bias[gate]) +
                                products(seen, of->inputs, gate, PORT_GRU_INPUTS));
        back[gate]  = products(states, of->states, gate, PORT_GRU_UNITS);
    }
    const uint16_t reset  = sigmoid((int16_t)((int16_t)(given[0] + back[0]) >> 1));
    const uint16_t update = sigmoid((int16_t)((int16_t)(given[1] + back[1]) >> 1));
    const int16_t  sum_u  = (int16_t)(port_rom_i16(&of->bias_u) + back[2]);
    const int16_t  sum_n  = (int16_t)(given[2] + share(sum_u, reset));
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
    int16_t sum = bias;

    for (uint8_t n = 0U; n < PORT_GRU_UNITS; ++n) {
        sum = (int16_t)(sum + product(&weights[n], states[n]));
    }
    return sum;
}

int16_t port_gru_log2_q8(uint16_t number)
{
    uint32_t left   = number;
    uint16_t log_q8 = 16U << 8;

    for (; left < 0x10000UL; left *= 2U) { log_q8 = (uint16_t)(log_q8 - (1U << 8)); }
    const uint32_t part = (left >> 8) & 0xFFU;
    return (int16_t)(log_q8 + part + ((part * (256U - part) / 256U * BULGE) >> 8));
}

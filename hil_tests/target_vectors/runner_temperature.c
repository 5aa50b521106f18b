/* SPDX-License-Identifier: MIT */
/* runner_temperature - serves the temperature compensation, in an image of its own. */
#include "runner.h"

#include "temperature.h"

#include <string.h>

enum {
    ASK_INIT    = 'i', /* temperature_config_t as the chip lays it out -> accepted u8 */
    ASK_UPDATE  = 'u', /* i16 -> known u8, temperature i16 */
    ASK_CORRECT = 'c', /* n x i32 -> n x i32 */
    ASK_COUNTS  = 'n'  /* -> refused u16, clipped u16 */
};

static temperature_config_t config;
static temperature_t        temperature;

static uint8_t correct(uint8_t buffer[], uint8_t len)
{
    for (uint8_t at = 0; at < len; at = (uint8_t)(at + sizeof(int32_t))) {
        int32_t counts;
        memcpy(&counts, &buffer[at], sizeof counts);
        counts = temperature_correct(&temperature, counts);
        memcpy(&buffer[at], &counts, sizeof counts);
    }
    return len;
}

static uint8_t update(uint8_t buffer[])
{
    int16_t centi;

    memcpy(&centi, buffer, sizeof centi);
    temperature_update(&temperature, centi);
    centi     = temperature_centi(&temperature);
    buffer[0] = temperature.known;
    memcpy(&buffer[1], &centi, sizeof centi);
    return 3;
}

uint8_t runner_serve(uint8_t op, uint8_t buffer[], uint8_t len)
{
    switch (op) {
    case ASK_INIT:
        memcpy(&config, buffer, sizeof config);
        buffer[0] = temperature_is_lawful(&config);
        if (buffer[0]) { temperature_init(&temperature, &config); }
        return 1;
    case ASK_UPDATE: return update(buffer);
    case ASK_CORRECT: return correct(buffer, len);
    case ASK_COUNTS:
        memcpy(buffer, &temperature.refused, 2);
        memcpy(&buffer[2], &temperature.clipped, 2);
        return 4;
    default: return 0;
    }
}

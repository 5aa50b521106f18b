/* SPDX-License-Identifier: MIT */
/* runner_zupt - serves the detectors of zero velocity, in an image of their own. */
#include "runner.h"

#include "zupt.h"

#include <string.h>

enum {
    ASK_INIT      = 'i', /* zupt_config_t as the chip lays it out -> accepted u8 */
    ASK_CHOOSE    = 'o', /* detector u8, rate u8 -> zupt_config_t */
    ASK_UPDATE    = 'u', /* n x gyro 3 i16, acc 3 i16 -> n x flag u8 */
    ASK_INTERRUPT = 'x',
    ASK_COUNTS    = 'n', /* -> rejected u16 */
    VECTOR_BYTES  = 6,
    SAMPLE_BYTES  = 2 * VECTOR_BYTES
};

static zupt_t zupt;

static uint8_t init(uint8_t buffer[])
{
    zupt_config_t config;

    memcpy(&config, buffer, sizeof config);
    buffer[0] = zupt_is_lawful(&config);
    if (buffer[0]) { zupt_init(&zupt, &config); }
    return 1;
}

static uint8_t update(uint8_t buffer[], uint8_t len)
{
    uint8_t reply = 0;

    for (uint8_t at = 0; at < len; at = (uint8_t)(at + SAMPLE_BYTES)) {
        int16_t gyro[3], acc[3];
        memcpy(gyro, &buffer[at], sizeof gyro);
        memcpy(acc, &buffer[at + VECTOR_BYTES], sizeof acc);
        buffer[reply++] = zupt_update(&zupt, gyro, acc);
    }
    return reply;
}

uint8_t runner_serve(uint8_t op, uint8_t buffer[], uint8_t len)
{
    switch (op) {
    case ASK_INIT: return init(buffer);
    case ASK_CHOOSE:
        zupt_choose(&zupt, buffer[0], buffer[1]);
        memcpy(buffer, &zupt.config, sizeof zupt.config);
        return sizeof zupt.config;
    case ASK_UPDATE: return update(buffer, len);
    case ASK_INTERRUPT: zupt_interrupt(&zupt); return 0;
    case ASK_COUNTS: memcpy(buffer, &zupt.rejected, 2); return 2;
    default: return 0;
    }
}

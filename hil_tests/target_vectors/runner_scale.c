/* SPDX-License-Identifier: MIT */
/* The first byte of the payload tells what is asked. */
#include "runner_scale.h"

#include "scale.h"

#include <string.h>

enum {
    ASK_INIT       = 0, /* scale_config_t as the chip lays it out -> status u8 */
    ASK_UPDATE     = 1, /* n x counts i32, device_us u32 -> n x flags u8, net, shown, pieces i32 */
    ASK_ZERO       = 2, /* the commands: -> status u8, net, shown, pieces i32 */
    ASK_TARE       = 3,
    ASK_TARE_CLEAR = 4,
    ASK_SHOW       = 5, /* what u16 */
    ASK_COUNT_OUT  = 6, /* pieces u16 */
    ASK_INTERRUPT  = 7,
    ASK_OUTCOME    = 8, /* -> steps u16, step_us u32, from, to, peak i32 */
    SAMPLE_BYTES   = 8,
    SAMPLES_MAX    = 18
};

static scale_config_t config, config_asked;
static scale_t        scale;

static uint8_t *put_i32(uint8_t *at, int32_t value)
{
    memcpy(at, &value, sizeof value);
    return at + sizeof value;
}

static uint8_t *put_answer(uint8_t *at, uint8_t answer)
{
    *at++ = answer;
    at    = put_i32(at, scale.net_mg);
    at    = put_i32(at, scale_shown(&scale));
    return put_i32(at, scale_pieces(&scale));
}

static uint8_t init(uint8_t buffer[])
{
    memcpy(&config_asked, &buffer[1], sizeof config_asked);
    buffer[0] = scale_init(&scale, &config_asked);
    if (buffer[0] == SCALE_OK) {
        config       = config_asked;
        scale.config = &config;
    }
    return 1;
}

static uint8_t update(uint8_t buffer[], uint8_t len)
{
    uint8_t  samples[SAMPLES_MAX * SAMPLE_BYTES]; /* the reply is longer than the request */
    uint8_t *reply = buffer;

    memcpy(samples, &buffer[1], len - 1U); /* the host keeps to SAMPLES_MAX */
    for (uint8_t at = 0; at < len - 1U; at = (uint8_t)(at + SAMPLE_BYTES)) {
        int32_t  counts_q7;
        uint32_t device_us;
        memcpy(&counts_q7, &samples[at], sizeof counts_q7);
        memcpy(&device_us, &samples[at + 4U], sizeof device_us);
        reply = put_answer(reply, scale_update(&scale, counts_q7, device_us));
    }
    return (uint8_t)(reply - buffer);
}

static uint8_t outcome(uint8_t buffer[])
{
    memcpy(buffer, &scale.steps, sizeof scale.steps);
    memcpy(&buffer[2], &scale.step_us, sizeof scale.step_us);
    uint8_t *at = put_i32(&buffer[6], scale.step_from_mg);
    at          = put_i32(at, scale.step_to_mg);
    return (uint8_t)(put_i32(at, scale.peak_mg) - buffer);
}

uint8_t runner_scale_serve(uint8_t buffer[], uint8_t len)
{
    uint8_t  status = SCALE_OK;
    uint16_t argument;

    memcpy(&argument, &buffer[1], sizeof argument);
    switch (buffer[0]) {
    case ASK_INIT: return init(buffer);
    case ASK_UPDATE: return update(buffer, len);
    case ASK_ZERO: status = scale_zero(&scale); break;
    case ASK_TARE: status = scale_tare(&scale); break;
    case ASK_TARE_CLEAR: scale_tare_clear(&scale); break;
    case ASK_SHOW: status = scale_show(&scale, (scale_show_t)argument); break;
    case ASK_COUNT_OUT: status = scale_count_out(&scale, argument); break;
    case ASK_INTERRUPT: scale_interrupt(&scale); break;
    default: return outcome(buffer);
    }
    return (uint8_t)(put_answer(buffer, status) - buffer);
}

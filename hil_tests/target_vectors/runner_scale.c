/* SPDX-License-Identifier: MIT */
/* runner_scale - serves scale and checkweigher, in an image of their own. */
#include "runner.h"

#include "checkweigher.h"
#include "scale.h"

#include <string.h>

enum {
    ASK      = 'W', /* the only op: the payload's first byte tells what is asked */
    ASK_INIT = 0,   /* scale_config_t as the chip lays it out -> status u8 */
    ASK_UPDATE =
        1, /* n x raw, counts i32, device_us u32 -> n x flags u8, net, shown, pieces, mass */
    ASK_ZERO       = 2, /* the commands: -> status u8, net, shown, pieces, mass of 0 */
    ASK_TARE       = 3,
    ASK_TARE_CLEAR = 4,
    ASK_SHOW       = 5, /* what u16 */
    ASK_COUNT_OUT  = 6, /* pieces u16 */
    ASK_INTERRUPT  = 7,
    ASK_OUTCOME    = 8,  /* -> steps u16, step_us u32, from, to, kept i32 */
    ASK_CHECK_INIT = 9,  /* checkweigher_config_t as the chip lays it out -> accepted u8 */
    ASK_CHECK      = 10, /* n x mass i32, device_us u32 -> n x event u8, weighed i32 */
    ASK_CHECK_DONE = 11, /* -> weighed u32, unweighed u16, entered_us, left_us u32, pace u16 */
    SAMPLE_BYTES   = 12,
    CHECK_BYTES    = 8,
    SAMPLES_MAX    = 14
};

static scale_config_t config, config_asked;
static scale_t        scale;

static checkweigher_config_t check_config, check_asked;
static checkweigher_t        check;

static uint8_t *put_i32(uint8_t *at, int32_t value)
{
    memcpy(at, &value, sizeof value);
    return at + sizeof value;
}

static uint8_t *put_answer(uint8_t *at, uint8_t answer, int32_t counts_q7)
{
    *at++ = answer;
    at    = put_i32(at, scale.net_mg);
    at    = put_i32(at, scale_shown(&scale));
    at    = put_i32(at, scale_pieces(&scale));
    return put_i32(at, scale_mass(&scale, counts_q7));
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
        int32_t  raw_q7, counts_q7;
        uint32_t device_us;
        memcpy(&raw_q7, &samples[at], sizeof raw_q7);
        memcpy(&counts_q7, &samples[at + 4U], sizeof counts_q7);
        memcpy(&device_us, &samples[at + 8U], sizeof device_us);
        const uint8_t flags = scale_update(&scale, counts_q7, raw_q7, device_us);
        reply               = put_answer(reply, flags, counts_q7);
    }
    return (uint8_t)(reply - buffer);
}

static uint8_t outcome(uint8_t buffer[])
{
    memcpy(buffer, &scale.steps, sizeof scale.steps);
    memcpy(&buffer[2], &scale.step_us, sizeof scale.step_us);
    uint8_t *at = put_i32(&buffer[6], scale.step_from_mg);
    at          = put_i32(at, scale.step_to_mg);
    return (uint8_t)(put_i32(at, scale.kept_mg) - buffer);
}

static uint8_t init_check(uint8_t buffer[])
{
    memcpy(&check_asked, &buffer[1], sizeof check_asked);
    buffer[0] = checkweigher_init(&check, &check_asked);
    if (buffer[0]) {
        check_config = check_asked;
        check.config = &check_config;
    }
    return 1;
}

static uint8_t update_check(uint8_t buffer[], uint8_t len)
{
    uint8_t reply = 0; /* shorter than what was read already */

    for (uint8_t at = 1; at < len; at = (uint8_t)(at + CHECK_BYTES)) {
        int32_t  mass_mg;
        uint32_t device_us;
        memcpy(&mass_mg, &buffer[at], sizeof mass_mg);
        memcpy(&device_us, &buffer[at + 4U], sizeof device_us);
        buffer[reply++] = (uint8_t)checkweigher_update(&check, mass_mg, device_us);
        put_i32(&buffer[reply], check.mass_mg);
        reply = (uint8_t)(reply + 4U);
    }
    return reply;
}

static uint8_t done_check(uint8_t buffer[])
{
    const uint16_t pace_q8 = checkweigher_per_minute_q8(&check);

    memcpy(buffer, &check.weighed, 4);
    memcpy(&buffer[4], &check.unweighed, 2);
    memcpy(&buffer[6], &check.entered_us, 4);
    memcpy(&buffer[10], &check.left_us, 4);
    memcpy(&buffer[14], &pace_q8, 2);
    return 16;
}

uint8_t runner_serve(uint8_t op, uint8_t buffer[], uint8_t len)
{
    uint8_t  status = SCALE_OK;
    uint16_t argument;

    if (op != ASK) { return 0; }
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
    case ASK_CHECK_INIT: return init_check(buffer);
    case ASK_CHECK: return update_check(buffer, len);
    case ASK_CHECK_DONE: return done_check(buffer);
    default: return outcome(buffer);
    }
    return (uint8_t)(put_answer(buffer, status, 0) - buffer);
}

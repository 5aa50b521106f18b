/* SPDX-License-Identifier: MIT */
/* runner_zupt_gru - serves the learnt detector of zero velocity, in an image of its own. */
#include "runner.h"

#include "zupt_gru.h"

#include <string.h>

enum {
    ASK_INIT      = 'i', /* sample_ms u8 */
    ASK_UPDATE    = 'u', /* n x gyro 3 i16, acc 3 i16 -> n x flag u8, seen 10 i16 */
    ASK_INTERRUPT = 'x',
    ASK_COUNTS    = 'n', /* -> rejected u16 */
    ASK_STEP      = 's', /* gyro 3 i16, acc 3 i16, from a step on, at 1 kHz */
    VECTOR_BYTES  = 6,
    SAMPLE_BYTES  = 2 * VECTOR_BYTES,
    SAMPLES_MAX   = 8
};

static zupt_gru_t gru;

typedef struct {
    int16_t gyro[3], acc[3];
} sample_t;

/* Every call of a step, to be measured as one. */
__attribute__((noinline)) static void zupt_gru_step(const sample_t *sample)
{
    for (uint8_t ms = 0; ms < ZUPT_GRU_STEP_MS; ms++) {
        zupt_gru_update(&gru, sample->gyro, sample->acc);
    }
}

static uint8_t update(uint8_t buffer[], uint8_t len)
{
    uint8_t samples[SAMPLES_MAX * SAMPLE_BYTES]; /* answers are longer: they would overtake */
    uint8_t reply = 0;

    memcpy(samples, buffer, len);
    for (uint8_t at = 0; at < len; at = (uint8_t)(at + SAMPLE_BYTES)) {
        int16_t gyro[3], acc[3];
        memcpy(gyro, &samples[at], sizeof gyro);
        memcpy(acc, &samples[at + VECTOR_BYTES], sizeof acc);
        buffer[reply++] = zupt_gru_update(&gru, gyro, acc);
        memcpy(&buffer[reply], gru.seen, sizeof gru.seen);
        reply = (uint8_t)(reply + sizeof gru.seen);
    }
    return reply;
}

uint8_t runner_serve(uint8_t op, uint8_t buffer[], uint8_t len)
{
    switch (op) {
    case ASK_INIT: zupt_gru_init(&gru, buffer[0]); return 0;
    case ASK_UPDATE: return update(buffer, len);
    case ASK_INTERRUPT: zupt_gru_interrupt(&gru); return 0;
    case ASK_COUNTS: memcpy(buffer, &gru.rejected, 2); return 2;
    case ASK_STEP: zupt_gru_step((const sample_t *)buffer); return 0;
    default: return 0;
    }
}

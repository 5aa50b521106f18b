/* SPDX-License-Identifier: MIT */
/* runner_faults - serves the faults of the converter, in an image of their own. */
#include "runner.h"

#include "faults.h"

#include <string.h>

enum {
    ASK_INIT   = 'i', /* noise_counts u16 */
    ASK_UPDATE = 'u', /* n x event u8, counts i32 -> n x answer u8, held u8; event 255: a pause */
    ASK_SEEN   = 's', /* -> u8 */
    PAUSE      = 255,
    ROW_BYTES  = 5
};

static faults_t faults;

static uint8_t update(uint8_t buffer[], uint8_t len)
{
    uint8_t reply = 0; /* shorter than what was read already */

    for (uint8_t at = 0; at < len; at = (uint8_t)(at + ROW_BYTES)) {
        const uint8_t event  = buffer[at];
        uint8_t       answer = 0;
        int32_t       counts;

        memcpy(&counts, &buffer[at + 1U], sizeof counts);
        if (event == PAUSE) {
            faults_pause(&faults);
        } else {
            answer = faults_update(&faults, (faults_event_t)event, counts);
        }
        buffer[reply++] = answer;
        buffer[reply++] = faults.held;
    }
    return reply;
}

uint8_t runner_serve(uint8_t op, uint8_t buffer[], uint8_t len)
{
    uint16_t noise_counts;

    switch (op) {
    case ASK_INIT:
        memcpy(&noise_counts, buffer, sizeof noise_counts);
        faults_init(&faults);
        faults_limit_noise(&faults, noise_counts);
        return 0;
    case ASK_UPDATE: return update(buffer, len);
    case ASK_SEEN: buffer[0] = faults.seen; return 1;
    default: return 0;
    }
}

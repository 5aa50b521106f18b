/* SPDX-License-Identifier: MIT */
#include "port_outline.h"
#include "port_reach.h"
#include "setup.h"
#include "weighing.h"
#include "weighing_internal.h"

#include <avr/pgmspace.h>
#include <string.h>

static const uint8_t results[] PROGMEM = {
    [SCALE_OK]           = MESSAGES_RESULT_OK,
    [SCALE_BAD_COUNT]    = MESSAGES_RESULT_TOO_FEW_POINTS,
    [SCALE_BAD_POINT]    = MESSAGES_RESULT_OUT_OF_RANGE,
    [SCALE_NOT_MONOTONE] = MESSAGES_RESULT_NOT_MONOTONE,
    [SCALE_TOO_STEEP]    = MESSAGES_RESULT_TOO_STEEP,
    [SCALE_BAD_RANGE]    = MESSAGES_RESULT_CONTRADICTS,
    [SCALE_BAD_DIVISION] = MESSAGES_RESULT_CONTRADICTS,
    [SCALE_BAD_TIME]     = MESSAGES_RESULT_CONTRADICTS,
    [SCALE_NOT_STABLE]   = MESSAGES_RESULT_NOT_STABLE,
    [SCALE_OUT_OF_RANGE] = MESSAGES_RESULT_OUT_OF_RANGE,
    [SCALE_TOO_LIGHT]    = MESSAGES_RESULT_TOO_LIGHT,
    [SCALE_UNKNOWN]      = MESSAGES_RESULT_OUT_OF_RANGE,
};

static uint8_t result_of(scale_status_t status)
{
    return pgm_read_byte(&results[status]);
}

/* Zero and tare outlive a reset as a command leaves them, not as zero tracking moves them. */
static PORT_OUTLINE uint8_t remember(scale_status_t status)
{
    if (status == SCALE_OK) {
        memcpy(&setup.zero_mg, &weighing_scale.zero_mg, 2U * sizeof setup.zero_mg);
        setup_save();
    }
    return result_of(status);
}

uint8_t weighing_zero(void)
{
    return remember(scale_zero(PORT_REACH(&weighing_scale)));
}

uint8_t weighing_tare(void)
{
    return remember(scale_tare(PORT_REACH(&weighing_scale)));
}

uint8_t weighing_tare_clear(void)
{
    scale_tare_clear(PORT_REACH(&weighing_scale));
    return remember(SCALE_OK);
}

uint8_t weighing_view(uint8_t view)
{
    return result_of(scale_show(PORT_REACH(&weighing_scale), (scale_show_t)view));
}

uint8_t weighing_count_pieces(uint16_t pieces)
{
    return result_of(scale_count_out(PORT_REACH(&weighing_scale), pieces));
}

uint8_t weighing_reset_counts(void)
{
    if (setup.checkweigher_on == 0U) { return MESSAGES_RESULT_WRONG_STATE; }
    weighing_renew_checkweigher();
    return MESSAGES_RESULT_OK;
}

bool weighing_is_calibrating(void)
{
    return weighing_calibrating;
}

uint8_t weighing_calibrate_begin(void)
{
    weighing_calibrating              = true;
    weighing_beside.calibration.count = 0;
    return MESSAGES_RESULT_OK;
}

/* Steady, not stable: by the old curve the load may well lie beyond Max, or far below zero. */
uint8_t weighing_calibrate_point(messages_point_t *point)
{
    if (!weighing_scale.steady) { return MESSAGES_RESULT_NOT_STABLE; }
    point->counts_q7 = weighing_last_counts_q7;
    return calibration_put(&weighing_beside.calibration, point);
}

uint8_t weighing_calibrate_known(messages_point_t *point)
{
    return calibration_put(&weighing_beside.calibration, point);
}

uint8_t weighing_calibrate_abort(void)
{
    weighing_calibrating = false;
    weighing_renew_checkweigher();
    return MESSAGES_RESULT_OK;
}

/* The new curve has another zero; what lies there now is surely no empty platform. */
uint8_t weighing_calibrate_end(void)
{
    calibration_swap(&weighing_beside.calibration, &setup.scale);
    static const int32_t none_mg[2];
    const scale_status_t status = weighing_renew(none_mg, true);

    if (status != SCALE_OK) {
        calibration_swap(&weighing_beside.calibration, &setup.scale);
        return result_of(status);
    }
    weighing_calibrate_abort();
    return remember(SCALE_OK);
}

uint8_t weighing_point(messages_point_t *point)
{
    const uint8_t         at        = point->index;
    const scale_config_t *config    = PORT_REACH(&setup.scale);
    const int32_t        *counts_q7 = config->point_counts_q7;
    uint8_t               count     = config->points;

    if (weighing_calibrating) {
        counts_q7 = weighing_beside.calibration.counts_q7;
        count     = weighing_beside.calibration.count;
    }
    if (at >= count) { return MESSAGES_RESULT_NOTHING_THERE; }
    point->counts_q7 = counts_q7[at];
    point->mass_mg   = counts_q7[at + SCALE_POINTS_MAX]; /* in both, masses stand behind counts */
    return MESSAGES_RESULT_OK;
}

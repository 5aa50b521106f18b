/* SPDX-License-Identifier: MIT */
/* weighing - the chain from conversions to a weight that one can trust, and what is done with it.
 *
 * Model     conversion -> [temperature] -> fir -> Kalman filter -> scale, in which order and with
 *           which Kalman filter the settings say. The first sample after a restart primes both
 *           filters and then passes through them like every other: fir_init(x); f = fir_update(x);
 *           kf_init(f); kf_update(f). The other order hands on the estimate in whole counts,
 *           rounded half up. Beside it: the same counts by the scale's curve, to its look ahead of
 *           the filters and to the checkweigher, which can wait for none
 * Trust     every event of the converter goes to faults; while one holds, the scale is interrupted
 *           at each sample and nothing is stable. A conversion that is not one period after the one
 *           before is not taken: the chip may have started anew, as after a loose contact, and
 *           then gives four wrong ones. What was lost is counted and flagged on the next sample
 * Memory    a calibration's points lie where the checkweigher is, which is off until its end
 * Formats   as in messages.toml; results are MESSAGES_RESULT_...
 * Bad data  a sample at the converter's rail passes, flagged, counted and not to be trusted
 * Context   main loop.  Cost: firmware/budget.toml
 */
#ifndef WEIGHING_H
#define WEIGHING_H

#include "hx711.h"
#include "messages.h"

#include <stdbool.h>
#include <stdint.h>

/* Since reset; each stops at its maximum. */
typedef struct {
    uint16_t conversions_missed;
    uint16_t at_rail;
    uint16_t fir_clipped;
    uint16_t kf_clipped;
} weighing_counters_t;

/* What HELLO says of the chain's filters. */
enum { WEIGHING_FIR_DESIGN = 0, WEIGHING_KF_SCHEDULE = 0, WEIGHING_FIR_TAPS = 32 };

/* Take the settings in force; false where they contradict one another, and then nothing but this
 * may be called. `running`: what lies there may be a load, so no zero is set by itself. */
bool weighing_setup(bool running);

/* The same for one setting that has changed; if false, nothing changes. */
bool weighing_setup_key(uint8_t key);

/* Take what the converter's driver tells; true if a sample came of it. */
bool weighing_take(messages_sample_t *sample, hx711_status_t status,
                   const hx711_conversion_t *conversion);

/* Behind weighing_take: a step, a product came of it; *device_us is when. */
bool weighing_step(messages_step_t *step, uint32_t *device_us);
bool weighing_product(messages_product_t *product, uint32_t *device_us);

/* What is shown now; faults are left to the caller. */
void weighing_show(messages_weight_t *weight);

/* A reading of the thermometer, or that there is none. */
void weighing_temperature(int16_t centi);
void weighing_no_temperature(void);

/* Counts are to be corrected, and the first reading may still come: nothing is stable. */
bool weighing_awaits_temperature(void);

/* Commands. If refused, nothing changes. */
uint8_t weighing_zero(void);
uint8_t weighing_tare(void);
uint8_t weighing_tare_clear(void);
uint8_t weighing_view(uint8_t view);
uint8_t weighing_count_pieces(uint16_t pieces);
uint8_t weighing_reset_counts(void);

/* A calibration under way. Whether it is the time for that is the caller's care. */
bool    weighing_is_calibrating(void);
uint8_t weighing_calibrate_begin(void);
uint8_t weighing_calibrate_point(messages_point_t *point); /* its mass is given */
uint8_t weighing_calibrate_known(messages_point_t *point); /* its counts too */
uint8_t weighing_calibrate_end(void);
uint8_t weighing_calibrate_abort(void);

/* The point of this index: of those taken so far, or of those in force. */
uint8_t weighing_point(messages_point_t *point);

uint32_t                   weighing_rate_hz_q16(void);
const weighing_counters_t *weighing_counters(void);

#endif

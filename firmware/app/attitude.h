/* SPDX-License-Identifier: MIT */
/* attitude - the chain from the IMU's samples to the attitude of the board, and to its stillness.
 *
 * Model     sample -> imu_cal -> imu_cal_turn -> rest -> mahony -> zupt; a field of the
 *           magnetometer is used with every sample until the next one comes. In the modes of a
 *           calibration there is no chain: samples are only handed on
 * Gaps      single samples that are lost are bridged with the last rate. An IMU that has been away
 *           sets the inclination anew with its first sample; heading and bias are kept
 * Formats   as in messages.toml
 * Bad data  an IMU that was there and does not answer is a fault, and so is a platform that rests
 *           askew; neither holds up the weighing
 * Context   main loop.  Cost: firmware/budget.toml
 */
#ifndef ATTITUDE_H
#define ATTITUDE_H

#include <stdbool.h>
#include <stdint.h>

/* Take the settings in force and begin anew. If they are refused (false), nothing has happened. */
bool attitude_setup(void);

/* The same for one setting that has changed. */
bool attitude_setup_key(uint8_t key);

/* Go on: to the next sample, if it has come. Call often: once in a sample's period at least. */
void attitude_poll(void);

/* Once a second: looks for a platform that stands askew, and sends IMU_STATUS once an IMU was
 * seen. */
void attitude_tick(void);

bool attitude_is_still(void);

/* 1/100 degC of the IMU, where samples of it come. */
bool attitude_temperature(int16_t *centi);

#endif

/* SPDX-License-Identifier: MIT */
/* runner_imu - the runner's requests for imu_cal and rest. */
#ifndef RUNNER_IMU_H
#define RUNNER_IMU_H

#include <stdint.h>

/* Do what was asked with the payload in the buffer; gives the length of the reply there. */
uint8_t runner_imu_serve(uint8_t op, uint8_t buffer[], uint8_t len);

#endif

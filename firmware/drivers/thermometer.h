/* SPDX-License-Identifier: MIT */
/* thermometer - the temperature of an MPU-6050 and nothing else of it, for a scale.
 *
 * Model     a round is asked for about once a second. It reads PWR_MGMT_1: if the part is awake, as
 *           only this driver makes it, TEMP_OUT is read; if it sleeps, as after its power-up, it is
 *           woken and this round gives nothing: what it measured asleep is not a temperature.
 *           Without memory between rounds: a part that comes, goes or is reset needs no more
 * Formats   1/100 degC = raw / 3.4 + 3653 (RM-MPU-6000A-00 rev. 4.2, p. 30)
 * Siblings  any part at address 0x68 is taken for one
 * Bad data  a part that does not answer, a bus that is stuck: missing, once a round
 * Context   main loop; an image has either this or mpu6050.  Cost: firmware/budget.toml
 */
#ifndef THERMOMETER_H
#define THERMOMETER_H

#include <stdint.h>

typedef enum {
    THERMOMETER_NOTHING, /* asked for nothing, or not there yet */
    THERMOMETER_READING, /* the out-parameter is filled */
    THERMOMETER_MISSING  /* this round found no part */
} thermometer_status_t;

/* Take the bus. */
void thermometer_init(void);

/* Begin a round, unless one is under way. */
void thermometer_ask(uint32_t now_us);

/* Go on with the round under way. */
thermometer_status_t thermometer_poll(int16_t *centi, uint32_t now_us);

#endif

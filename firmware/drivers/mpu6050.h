/* SPDX-License-Identifier: MIT */
/* mpu6050 - driver of the IMU MPU-6050 at address 0x68: bursts of registers, temperature, health.
 *
 * Model     one engine of steps, each a transfer of twi: who is it (register 0x75); one write a
 *           pair of the setup; then a burst whenever asked for, and after every guard_every bursts
 *           the last pair's register is read: another value than was written means that the part
 *           was reset, and it is set up anew.  Register map RM-MPU-6000A-00 rev. 4.2
 * Setups    mpu6050_thermometer: awake, temperature alone (2 bytes).  mpu6050_motion_...: 14 bytes
 *           at the rate and ranges of its name. What an image does not name is not linked
 * Formats   burst: the part's own bytes, big-endian    temperature: 1/100 degC = raw / 3.4 + 3653
 *           (register map p. 30)    device_us: when the burst was asked for
 * Siblings  WHO_AM_I of 0x98, 0x72, 0x70 and anything else but 0x68 is told by mpu6050_identity and
 *           served alike
 * Bad data  a part that does not answer is absent: it is asked for again every 250 ms, and set up
 *           when it answers. A burst asked for while the last is under way is not made and counted
 *           in `overruns`. No burst is handed on that was begun before a set-up
 * Context   main loop; mpu6050_request also from an interrupt handler.  Cost: firmware/budget.toml
 */
#ifndef MPU6050_H
#define MPU6050_H

#include <stdbool.h>
#include <stdint.h>

enum { MPU6050_ADDRESS = 0x68, MPU6050_WHO_AM_I = 0x68, MPU6050_BURST_MAX = 14 };

/* A constant of program memory. */
typedef struct {
    uint8_t first_register; /* of the burst */
    uint8_t burst_len;      /* <= MPU6050_BURST_MAX */
    uint8_t guard_every;    /* bursts, >= 1 */
    uint8_t pair_count;     /* >= 1 */
    uint8_t pairs[8][2];    /* register, value; the last is read back as guard */
} mpu6050_setup_t;

typedef enum {
    MPU6050_ABSENT,   /* nobody answers, or the bus is stuck */
    MPU6050_STARTING, /* answers; being set up */
    MPU6050_RUNNING
} mpu6050_state_t;

/* Since reset; each stops at its maximum. */
typedef struct {
    uint16_t overruns; /* bursts asked for too early */
    uint16_t losses;   /* the part stopped answering, or was found reset */
} mpu6050_counters_t;

/* Temperature alone, awake. */
extern const mpu6050_setup_t mpu6050_thermometer;

/* Begin with that setup, in program memory; the bus is taken with it. */
void mpu6050_init(const mpu6050_setup_t *setup);

/* Ask for one burst. */
void mpu6050_request(uint32_t now_us);

/* Go on with what is under way; true: a burst has come, read it before the next request. */
bool mpu6050_poll(uint32_t now_us);

mpu6050_state_t           mpu6050_state(void);
uint8_t                   mpu6050_identity(void); /* WHO_AM_I, 0 while it never answered */
const mpu6050_counters_t *mpu6050_counters(void);

/* Of the burst that has come, for a burst of the thermometer. */
int16_t mpu6050_temperature_centi(void);

#endif

/* SPDX-License-Identifier: MIT */
/* mpu6050 - driver of the IMU MPU-6050 at address 0x68: presence, set-up, bursts of registers.
 *
 * Model     one engine of steps, each a transfer of twi: who is it (register 0x75); one write a
 *           pair of the setup; 35 ms of settling (product specification rev. 3.4, p. 12: gyroscope
 *           start-up 30 ms); then a burst whenever one is asked for. After every guard_every
 *           bursts the register of the last pair is read: another value than was written there
 *           means that the part was reset, and it is set up anew. The same after 8 ms without a
 *           burst, as nobody asks for one when the part tells of no data
 * Setups    in mpu6050_motion.h
 * Formats   burst: the part's own bytes, big-endian, into the caller's buffer
 * Siblings  WHO_AM_I other than 0x68 (0x98, 0x72, 0x70 have been seen) is told by mpu6050_identity
 *           and served alike
 * Bad data  a part that does not answer is absent: it is asked again every quarter of a second, and
 *           set up when it answers. A burst that cannot be begun yet waits; one more is not made
 *           and counted in `overruns`. What was asked for before a set-up is forgotten
 * Context   main loop; mpu6050_request also from an interrupt handler.  Cost: firmware/budget.toml
 */
#ifndef MPU6050_H
#define MPU6050_H

#include <stdbool.h>
#include <stdint.h>

enum { MPU6050_ADDRESS = 0x68, MPU6050_WHO_AM_I = 0x68, MPU6050_PAIRS_MAX = 8 };

/* A constant in program memory. */
typedef struct {
    uint8_t first_register; /* of the burst */
    uint8_t burst_len;      /* >= 1 */
    uint8_t guard_every;    /* bursts, >= 1 */
    uint8_t pair_count;     /* >= 1 */
    struct {
        uint8_t reg, value;
    } pairs[MPU6050_PAIRS_MAX]; /* the last is the guard */
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

/* Begin with that setup; takes the bus. */
void mpu6050_init(const mpu6050_setup_t *setup);

/* Ask for one burst into a buffer of the setup's burst_len; false: it will not be made, the part
 * does not run, or a burst waits already. */
bool mpu6050_request(uint8_t *burst, uint32_t now_us);

/* Go on with what is under way; true: the burst asked for has come. */
bool mpu6050_poll(uint32_t now_us);

mpu6050_state_t    mpu6050_state(void);
uint8_t            mpu6050_identity(void); /* WHO_AM_I; 0: it never answered */
mpu6050_counters_t mpu6050_counters(void);

/* 1/100 degC of two bytes of TEMP_OUT: raw / 3.4 + 3653, register map rev. 4.2, p. 30. */
int16_t mpu6050_temperature_centi(const uint8_t temp_out[2]);

#endif

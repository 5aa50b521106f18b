/* SPDX-License-Identifier: MIT */
/* mpu6050_internal - what mpu6050_motion and the interrupts that pace it, mpu6050_pace, share. */
#ifndef MPU6050_INTERNAL_H
#define MPU6050_INTERNAL_H

#include <stdbool.h>
#include <stdint.h>

#include "mpu6050.h"

enum {
    MPU6050_WORDS     = 7,
    MPU6050_BURST_LEN = 2 * MPU6050_WORDS,
    MPU6050_RATES_LEN = 4,
    MPU6050_PATIENCE  = 256 /* ticks: more than 3 % of a period; the part's clock may be slow */
};

typedef struct {
    uint8_t step;
    bool    is_asked; /* to begin anew */
    uint8_t mode;
    uint8_t since;      /* when a wait began, 1.024 ms */
    uint8_t guard_left; /* bursts until the guard is read */
    uint8_t guard;      /* as read */
    uint8_t identity;
    /* as written: the rates, INT_PIN_CFG, INT_ENABLE */
    uint8_t           settings[MPU6050_RATES_LEN + 2];
    uint8_t           burst[MPU6050_BURST_LEN];
    uint16_t          period; /* main loop writes, interrupts read; tick */
    volatile uint16_t due;    /* tick of the burst under way; who begins it writes, poll reads */
    /* the same of one that waits; interrupts write while none waits, poll reads while one does */
    volatile uint16_t  waiting_due;
    mpu6050_counters_t counters;
} mpu6050_t;

extern mpu6050_t mpu6050;

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* magnetometer - QMC5883L (address 0x0D) or HMC5883L (0x1E) as its registers show it.
 *
 * Model     QST QMC5883L datasheet 1.0: 10..200 Hz continuous, 12000 or 3000 counts a gauss, little
 *           endian, DRDY, OVL and DOR in 0x06, chip identity 0xFF in 0x0D, soft reset.
 *           Honeywell HMC5883L datasheet rev. E: 0.75..75 Hz continuous or single, 1370..230 counts
 *           a gauss, big-endian in the order X Z Y, -4096 for what is beyond the range, `H43` in
 *           0x0A, pointer from 0x08 back to 0x03
 * Not here  interrupt pins, bias self-test, roll-over control, averaging
 * Knows not the board: time is ticks of the caller's choice
 */
#ifndef MAGNETOMETER_H
#define MAGNETOMETER_H

#include <stdbool.h>
#include <stdint.h>

#include "uno.h"

enum { MAGNETOMETER_REGISTERS = 16 };

/* The field at one instant in gauss, on the part's axes. */
typedef void (*magnetometer_source_fn)(void *ctx, uint64_t tick, double field[3]);

typedef struct {
    uint8_t                kind; /* UNO_MAG_QMC5883L, UNO_MAG_HMC5883L */
    double                 hz;
    magnetometer_source_fn source;
    void                  *ctx;
    uint8_t                regs[MAGNETOMETER_REGISTERS];
    uint8_t                pointer;
    bool                   pointer_set;
    bool                   single; /* the HMC5883L measures once, then idles */
    uint64_t               now;
    double                 due; /* tick of the next sample; infinite: idle */
    uint64_t               samples;
} magnetometer_t;

void     magnetometer_power_on(magnetometer_t *mag, uint64_t tick);
void     magnetometer_advance(magnetometer_t *mag, uint64_t tick);
uint64_t magnetometer_next_tick(const magnetometer_t *mag);

bool    magnetometer_start(magnetometer_t *mag, bool reading);
bool    magnetometer_write(magnetometer_t *mag, uint8_t byte);
uint8_t magnetometer_read(magnetometer_t *mag);

#endif

/* SPDX-License-Identifier: MIT */
#include "magnetometer.h"

#include "mpu6050_motion.h"
#include "port_reach.h"
#include "rom_next.h"
#include "twi.h"

#include <avr/pgmspace.h>

enum { WRITES = 3, AXES = 3, READ_LEN = 7 };

/* In units of 1.024 ms; a wait is looked at every 33 ms at least, and must not reach 256. */
enum { READ_TIME = 13, RETRY_TIME = 200 };

enum {
    READS   = 64,   /* until the part is set up anew, a power of 2 */
    QMC_OVL = 0x02, /* of the status behind the axes */
    /* -4096 of the HMC5883L; of a QMC5883L 1.37 gauss, which no field on earth is */
    BEYOND_HIGH = 0xF0
};

/* Address, registers with what is written there, first register of a reading. */
static const uint8_t parts[2][2 * WRITES + 2] PROGMEM = {
    {0x0D << 1, 0x0B, 0x01, 0x0A, 0x01, 0x09, 0x19, 0x00},
    {0x1E << 1, 0x00, 0x18, 0x01, 0x20, 0x02, 0x00, 0x03},
};

enum { QMC = 0, HMC = sizeof parts[0], READING = 2 * WRITES };

typedef struct {
    uint8_t step; /* twice the writes done */
    uint8_t part; /* which is asked: QMC, HMC, where its row stands */
    uint8_t kind;
    uint8_t since, wait; /* 1.024 ms */
    uint8_t reads;
    uint8_t bytes[READ_LEN];
} mag_t;

static mag_t mag;

static void ask(mag_t *it)
{
    const uint8_t *row = parts[0] + it->part;
    uint8_t        sla = rom_next(&row);
    uint8_t        len = 1;

    row += it->step;
    const uint8_t reg = rom_next(&row);
    it->bytes[0]      = rom_next(&row); /* where it is read, this goes nowhere */
    if (it->step == READING) {
        sla |= 1U;
        len = READ_LEN;
    }
    twi_ready(sla, reg, it->bytes, len);
    twi_go();
}

/* false: no field. */
static bool take(const mag_t *it, int16_t mag_counts[AXES])
{
    const uint8_t *from = it->bytes;
    uint8_t       *to   = (uint8_t *)mag_counts;
    uint8_t        any  = 0;

    for (uint8_t left = AXES; left != 0U; left--) {
        uint8_t low  = *from++;
        uint8_t high = *from++;
        if (it->part != QMC) {
            const uint8_t first = low;
            low                 = high;
            high                = first;
        }
        *to++ = low;
        *to++ = high;
        any |= low | high;
        if (low == 0U && high == BEYOND_HIGH) { return false; }
    }
    if (it->part != QMC) {
        const int16_t second = mag_counts[1];
        mag_counts[1]        = mag_counts[2];
        mag_counts[2]        = second;
    } else if ((*from & QMC_OVL) != 0U) {
        return false;
    }
    return any != 0U;
}

bool magnetometer_poll(int16_t mag_counts[AXES], uint32_t now_us)
{
    mag_t *const  it   = PORT_REACH(&mag);
    const uint8_t now  = twi_time(now_us);
    bool          come = false;

    if (!mpu6050_is_lent()) {
        if ((uint8_t)(now - it->since) >= it->wait && mpu6050_lend()) { ask(it); }
        return false;
    }
    const uint8_t status = twi_poll(now);
    if (status == TWI_BUSY) { return false; }
    it->since = now;
    it->wait  = READ_TIME;
    if (status != TWI_IDLE) {
        it->wait = RETRY_TIME;
        it->kind = MAGNETOMETER_NONE;
        it->step = 0;
        it->part = (uint8_t)(it->part ^ HMC);
    } else if (it->step != READING) {
        it->step = (uint8_t)(it->step + 2U);
    } else {
        it->kind = it->part == QMC ? MAGNETOMETER_QMC5883L : MAGNETOMETER_HMC5883L;
        it->reads++;
        if (it->reads % READS == 0U) { it->step = 0; }
        come = take(it, mag_counts);
    }
    mpu6050_give_back();
    return come;
}

uint8_t magnetometer_kind(void)
{
    return mag.kind;
}

/* SPDX-License-Identifier: MIT */
/* lamp - the board's LED tells a person what is wrong, without a host.
 *
 * Model     all is well: half a second lit, half a second dark. Else: so many flashes as the number
 *           of the fault says, FAULT of messages.toml counted from one, and a pause; of several
 *           faults the one with the least number, which is the worst. A fault shows at once, and
 *           for one whole turn at least, however short it was.
 * Formats   faults: bits    device_us: us, wrapping; of it 65 ms are seen
 * Context   main loop, at least every 65 ms
 */
#ifndef LAMP_H
#define LAMP_H

#include <stdint.h>

void lamp_init(void); /* lit, until the first half second is over */

void lamp_update(uint16_t faults, uint32_t device_us);

#endif

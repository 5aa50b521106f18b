/* SPDX-License-Identifier: MIT */
/* port_fir - the FIR's inner loop, folded about its middle.
 *
 * Model     (sum_{k<pairs} c[k] (w[k] + w[2 pairs - 1 - k]) - 2^38 + 2^14) >> 15
 *           The window holds counts + 2^23, so that every byte is unsigned; as all taps sum to
 *           2^15, that offset adds 2^38, which is taken off here.
 * Formats   w: 24-bit, least byte first, 3 bytes each, oldest first; c: Q15 in ROM
 *           |sum| < 2^39, because sum |c| < 2^16: 40 bits are enough, and |result| <= 2^24
 */
#ifndef PORT_FIR_H
#define PORT_FIR_H

#include <stdint.h>

int32_t port_fir_fold(const uint8_t window[], const int16_t half_q15[], uint8_t pairs);

#endif

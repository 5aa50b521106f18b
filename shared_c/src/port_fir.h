/* SPDX-License-Identifier: MIT */
/* port_fir - the FIR's window, and its inner loop, folded about its middle.
 *
 * Model     (sum_{k<pairs} c[k] (w[k] + w[taps - 1 - k])  [+ c[pairs] w[pairs] if taps is odd]
 *            - 2^38 + 2^14) >> 15,   pairs = taps / 2,   w[0] the oldest sample
 *           The window holds counts + 2^23, so that every byte is unsigned; as all taps sum to
 *           2^15, that offset adds 2^38, which is taken off here.
 * Formats   w: 24-bit, least byte first, 3 bytes each; c: Q15
 *           |sum| < 2^39, because sum |c| < 2^16: 40 bits are enough, and |result| <= 2^24
 */
#ifndef PORT_FIR_H
#define PORT_FIR_H

#include <stdint.h>

#include "fir.h"

/* A sample within 24 bits into the window, in place of the oldest one; `next` is then where the
 * oldest is. If the configuration is `twice`, it is written once more behind all of them. */
void port_fir_take(fir_t *fir, int32_t sample_counts, const fir_config_t *twice);

/* Of a ring of taps samples, the oldest of which begins at the byte `oldest`. */
int32_t port_fir_fold(const uint8_t ring[], const fir_config_t *config, uint8_t oldest);

/* Of samples in a row, for fir_designs[0], which is `config`. A port may know its coefficients by
 * heart: firmware/port/generated. Its taps have room twice in the window. */
int32_t port_fir_fold_default(const uint8_t row[], const fir_config_t *config);

#endif

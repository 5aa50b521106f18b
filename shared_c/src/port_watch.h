/* SPDX-License-Identifier: MIT */
/* port_watch - whether what a scale measures stands: a third of scale's time. Part of the seam.
 *
 * Model     in grains of 2^grain counts Q7:  at, raw = how far counts_q7, raw_q7 lie above
 *           anchor_q7, modulo 2^32, limited to 12 bits;  rough = rough_q4 / 16 as it was;
 *           leap = |raw - the last raw|, or 4095 where raw was limited: it may have leapt out
 *           there;  rough_q4 += min(leap, 1.5 rough + 4) - rough;
 *           lag_q3 += (raw - at, limited to +-wide) - lag_q3 / 8, wide = max(band, rough);
 *           low and high take in at;  it stands if begun, if high - low <= band, or 1.5 bands while
 *           steady, else half a band while early; if |lag_q3| <= 4 wide or it is early and not
 *           steady; and if raw is within reach of low and of high, reach = band + max(3/4 band,
 *           4 rough). All is rounded down, 3/4 band up. If it does not stand, low, high and raw
 *           begin anew from at
 * Bounds    band <= 255: low in -382..0, high in 0..382; a leap is at most 4095, thus rough_q4
 *           below 2^16, and |lag_q3| at most 8 * 4095 < 2^15
 */
#ifndef PORT_WATCH_H
#define PORT_WATCH_H

#include "scale.h"

bool port_watch(scale_t *scale, int32_t counts_q7, int32_t raw_q7, bool early);

#endif

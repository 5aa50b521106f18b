/* SPDX-License-Identifier: MIT */
/* text - lines for a person who has nothing but a serial monitor.
 *
 * Model     samples in the form of the Arduino Serial Plotter:
 *           `raw:-12,fir:-11,kf:-11,weight_g:-0.026,stable:0`. Every other line starts with `#`
 *           and holds
 *           no bare number, which the plotter would draw.
 * Formats   raw, fir and kf in counts, kf rounded half up; net weight in g with three decimals
 * Room      the caller sees to it that the transmit buffer takes TEXT_LINE_MAX characters a line;
 *           without that a line would be torn
 * Context   main loop
 */
#ifndef TEXT_H
#define TEXT_H

#include "messages.h"

#include <stdint.h>

/* "raw:-8388608,fir:-8388608,kf:-8388608,weight_g:-2147483.648,stable:0\r\n" is the longest. */
enum { TEXT_LINE_MAX = 72 };

void text_sample(const messages_sample_t *sample);
void text_version(void);
void text_converter(uint8_t gain, uint32_t rate_hz_q16);

/* What became of the command `word`. */
void text_answer(const char *word, uint8_t result);

#endif

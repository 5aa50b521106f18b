/* SPDX-License-Identifier: MIT */
/* text - lines for a person who has nothing but a serial monitor.
 *
 * Model     samples in the form of the Arduino Serial Plotter:
 *           `raw:-12,fir:-11,kf:-11,weight_g:-0.026,stable:0`. Every other line starts with `#`
 *           and holds
 *           no bare number, which the plotter would draw.
 * Formats   raw, fir and kf in counts, kf rounded half up; net weight in g with three decimals
 * Context   main loop; pure but for the line it fills
 */
#ifndef TEXT_H
#define TEXT_H

#include "messages.h"

#include <stdint.h>

/* "raw:-8388608,fir:-8388608,kf:-8388608,weight_g:-2147483.648,stable:0\r\n" is the longest. */
enum { TEXT_LINE_MAX = 72 };

typedef struct {
    char    characters[TEXT_LINE_MAX]; /* no terminator */
    uint8_t len;                       /* what does not fit is left out */
} text_line_t;

void text_sample(text_line_t *line, const messages_sample_t *sample);
void text_version(text_line_t *line);
void text_converter(text_line_t *line, uint8_t gain, uint32_t rate_hz_q16);

/* What became of the command `word`. */
void text_answer(text_line_t *line, const char *word, uint8_t result);

#endif

/* SPDX-License-Identifier: MIT */
/* words - commands for a person who has nothing but a serial monitor.
 *
 * Model     a line is one of the words `text`, `frames`, `tare`, `clear`, `zero`, `info` and an end
 *           of line, and does what its frame command does. Every received byte goes to the frame
 *           decoder, too; the two cannot be taken for one another: a command frame starts with a
 *           COBS code of at most 3, because a host's device_us is 0, so no printable line ever
 *           starts it; and a line holds no 0x00, so it never ends as a frame.
 * Answers   a line in text mode, an ACK with sequence 0 else
 * Bad data  whatever comes is survived; a line that means nothing is counted
 * Context   main loop
 */
#ifndef WORDS_H
#define WORDS_H

#include <stdbool.h>
#include <stdint.h>

void words_init(void);

/* Take one received byte. True if it ended a line: then the frame decoder must forget the line's
 * bytes, or it would take them for the head of the next frame. */
bool words_receive(uint8_t byte);

#endif

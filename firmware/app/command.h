/* SPDX-License-Identifier: MIT */
/* command - what a host or a person may ask of the device.
 *
 * Model     every received byte goes to the frame decoder and to the collector of lines. A line is
 *           one of the words `text`, `frames`, `tare`, `info` and an end of line, and does what the
 *           frame command does. The two cannot be taken for one another: a command frame starts
 *           with a COBS code of at most 3, because a host's device_us is 0, so no printable line
 *           ever starts it; and a line holds no 0x00, so it never ends as a frame.
 * Answers   to a frame: ACK with its sequence, in either mode. To a line: a line in text mode, an
 *           ACK with sequence 0 else. A command that is refused changes nothing.
 * Bad data  whatever comes is survived; a body or a line that means nothing is counted
 * Context   main loop
 */
#ifndef COMMAND_H
#define COMMAND_H

#include <stdint.h>

void command_init(void);

/* Take one received byte and act on what it completes. */
void command_receive(uint8_t byte);

#endif

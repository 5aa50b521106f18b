/* SPDX-License-Identifier: MIT */
/* command - what a host may ask of the device, by frames.
 *
 * Model     one table says of each command how long it is, what its first field may be and whether
 *           it has its time in the middle of a calibration. Refused in this order: unknown command,
 *           wrong length, out of range, calibrating or not calibrating; then the command itself
 *           may still refuse
 * Answers   an ACK, and behind it what was asked for. A command that is refused changes nothing
 * Bad data  whatever comes is survived; a body that means nothing is counted
 * Context   main loop
 */
#ifndef COMMAND_H
#define COMMAND_H

#include <stdint.h>

void command_init(void);

/* Take one received byte and act on what it completes. */
void command_receive(uint8_t byte);

/* Do what a frame of this command would, answers left out; MESSAGES_RESULT_... `on` is the payload
 * of SET_TEXT_MODE; there is no other command with a payload among them. */
uint8_t command_run(uint8_t id, uint8_t on);

/* Answer it: by an ACK, and HELLO and STATUS where those were asked for. */
void command_acknowledge(uint8_t id, uint8_t sequence, uint8_t result);

#endif

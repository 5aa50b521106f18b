/* SPDX-License-Identifier: MIT */
/* telemetry - everything the device sends: frames for a host, or text lines for a person.
 *
 * Formats   frames as in shared_c/PROTOCOL.md; lines as in text.h
 * Bad data  what does not fit in the transmit buffer is left out whole and counted. Its sequence
 *           number is used up all the same, so that the receiver sees the hole.
 * Context   main loop.  Cost: firmware/budget.toml
 */
#ifndef TELEMETRY_H
#define TELEMETRY_H

#include "messages.h"

#include <stdbool.h>
#include <stdint.h>

/* Streaming as the settings say. */
void telemetry_init(void);

/* Once around the main loop: keeps the second's figures and sends what has its time. */
void telemetry_tick(uint32_t now_us);

/* One conversion through the chain, and what came of it, as far as it is to be streamed: as frames
 * or as a line. */
void telemetry_sample(const messages_sample_t *sample, uint32_t device_us);

void telemetry_hello(void);
void telemetry_status(void);

/* A message as it lies in memory: one that is streamed, unless that is not wanted or a person is
 * reading; and an answer. */
void telemetry_stream(uint8_t flag, uint8_t id, uint32_t device_us, const void *payload,
                      uint8_t len);
void telemetry_answer(uint8_t id, const void *message, uint8_t len);

/* The same for a person. Names a result of messages.toml and the word it answers. */
void telemetry_info_lines(void);
void telemetry_answer_line(const char *word, uint8_t result);

void telemetry_set_stream(uint8_t mask);
void telemetry_set_text_mode(uint8_t on);
bool telemetry_text_mode(void);

/* A received byte sequence that was neither frame nor command line. */
void telemetry_count_bad_rx(void);

#endif

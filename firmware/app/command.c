/* SPDX-License-Identifier: MIT */
#include "command.h"

#include "frame.h"
#include "messages.h"
#include "telemetry.h"
#include "weighing.h"

#include <avr/pgmspace.h>
#include <stdbool.h>
#include <string.h>

enum {
    WORD_MAX    = 7,   /* characters of the longest line that is taken */
    LINE_BROKEN = 0xFF /* too long or not printable: nothing until its end */
};

static frame_decoder_t decoder;
static char            word[WORD_MAX + 1];
static uint8_t         word_len; /* 0..WORD_MAX, or LINE_BROKEN */
static bool            after_return;

void command_init(void)
{
    frame_decoder_init(&decoder);
    word_len     = 0;
    after_return = false;
}

static uint8_t set_stream(const uint8_t payload[], uint8_t len)
{
    messages_set_stream_t command;

    if (len != MESSAGES_SET_STREAM_LEN) { return MESSAGES_RESULT_WRONG_LENGTH; }
    if (!messages_set_stream_unpack(&command, payload, len)) {
        return MESSAGES_RESULT_OUT_OF_RANGE;
    }
    telemetry_set_stream(command.mask);
    return MESSAGES_RESULT_OK;
}

static uint8_t set_text_mode(const uint8_t payload[], uint8_t len)
{
    messages_set_text_mode_t command;

    if (len != MESSAGES_SET_TEXT_MODE_LEN) { return MESSAGES_RESULT_WRONG_LENGTH; }
    if (!messages_set_text_mode_unpack(&command, payload, len)) {
        return MESSAGES_RESULT_OUT_OF_RANGE;
    }
    telemetry_set_text_mode(command.on != 0U);
    return MESSAGES_RESULT_OK;
}

static uint8_t tare(uint8_t len)
{
    if (len != MESSAGES_TARE_LEN) { return MESSAGES_RESULT_WRONG_LENGTH; }
    return weighing_tare();
}

static uint8_t get_info(uint8_t len)
{
    return len == MESSAGES_GET_INFO_LEN ? MESSAGES_RESULT_OK : MESSAGES_RESULT_WRONG_LENGTH;
}

static uint8_t execute(uint8_t id, const uint8_t payload[], uint8_t len)
{
    switch (id) {
    case MESSAGES_GET_INFO_ID: return get_info(len);
    case MESSAGES_SET_STREAM_ID: return set_stream(payload, len);
    case MESSAGES_SET_TEXT_MODE_ID: return set_text_mode(payload, len);
    case MESSAGES_TARE_ID: return tare(len);
    default: return MESSAGES_RESULT_UNKNOWN_COMMAND;
    }
}

static void answer_by_frame(uint8_t id, uint8_t sequence, uint8_t result)
{
    const messages_ack_t ack = {.command = id, .command_sequence = sequence, .result = result};

    telemetry_ack(&ack);
    if (result != MESSAGES_RESULT_OK || id != MESSAGES_GET_INFO_ID) { return; }
    telemetry_hello();
    telemetry_status();
}

static void answer_by_line(uint8_t id, uint8_t result)
{
    if (id == MESSAGES_GET_INFO_ID) {
        telemetry_info_lines();
    } else {
        telemetry_answer_line(word, result);
    }
}

static void run_frame(void)
{
    frame_t frame;

    frame_decoder_read(&decoder, &frame);
    answer_by_frame(frame.id, frame.sequence, execute(frame.id, frame.payload, frame.payload_len));
}

/* The word's command and the one byte of payload it stands for; 0 is no command's id. */
static uint8_t look_up(uint8_t *payload)
{
    *payload = 0;
    if (strcmp_P(word, PSTR("tare")) == 0) { return MESSAGES_TARE_ID; }
    if (strcmp_P(word, PSTR("info")) == 0) { return MESSAGES_GET_INFO_ID; }
    if (strcmp_P(word, PSTR("frames")) == 0) { return MESSAGES_SET_TEXT_MODE_ID; }
    if (strcmp_P(word, PSTR("text")) == 0) {
        *payload = 1;
        return MESSAGES_SET_TEXT_MODE_ID;
    }
    return 0;
}

static void run_word(void)
{
    uint8_t       payload;
    const uint8_t id     = look_up(&payload);
    const uint8_t len    = id == MESSAGES_SET_TEXT_MODE_ID ? MESSAGES_SET_TEXT_MODE_LEN : 0U;
    const uint8_t result = execute(id, &payload, len);

    if (result == MESSAGES_RESULT_UNKNOWN_COMMAND) { telemetry_count_bad_rx(); }
    if (telemetry_text_mode()) {
        answer_by_line(id, result);
    } else if (result != MESSAGES_RESULT_UNKNOWN_COMMAND) {
        answer_by_frame(id, 0, result);
    }
}

/* True if the byte ended a line: then the frame decoder must forget the line's bytes, or it would
 * take them for the head of the next frame. */
static bool collect_line(uint8_t byte)
{
    const bool is_return   = byte == '\r';
    const bool is_line_end = is_return || byte == '\n';
    const bool second_half = byte == '\n' && after_return; /* of \r\n */

    after_return = false;
    if (byte == 0U) {
        word_len = 0;
    } else if (!is_line_end) {
        const bool fits = word_len < WORD_MAX && byte >= ' ' && byte <= '~';
        if (fits) {
            word[word_len++] = (char)byte;
        } else {
            word_len = LINE_BROKEN;
        }
    } else if (word_len != 0U && word_len != LINE_BROKEN) {
        word[word_len] = '\0';
        word_len       = 0;
        after_return   = is_return;
        run_word();
        return true;
    } else {
        word_len = 0;
    }
    return second_half;
}

void command_receive(uint8_t byte)
{
    switch (frame_decoder_push(&decoder, byte)) {
    case FRAME_READY: run_frame(); break;
    case FRAME_PENDING: break;
    case FRAME_BAD_COBS:
    case FRAME_BAD_LEN:
    case FRAME_BAD_CRC:
    default: telemetry_count_bad_rx(); break;
    }
    if (collect_line(byte)) { frame_decoder_init(&decoder); }
}

/* SPDX-License-Identifier: MIT */
#include "command.h"

#include "frame.h"
#include "messages.h"
#include "setup.h"
#include "telemetry.h"
#include "weighing.h"
#include "words.h"

#include <avr/pgmspace.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

/* When a command has its time. */
enum {
    ANY_TIME,
    NOT_CALIBRATING, /* refused in the middle of a calibration */
    CALIBRATING      /* refused outside of one */
};

enum { ANY = 255 };

typedef struct {
    uint8_t id;
    uint8_t len;  /* of the payload */
    uint8_t most; /* greatest value of the first byte */
    uint8_t time;
} rule_t;

#define RULE(name, most, time)                                  \
    {                                                           \
        MESSAGES_##name##_ID, MESSAGES_##name##_LEN, most, time \
    }

static const rule_t rules[] PROGMEM = {
    RULE(GET_INFO, ANY, ANY_TIME),
    RULE(SET_STREAM, MESSAGES_SET_STREAM_MASK_MAX, ANY_TIME),
    RULE(SET_TEXT_MODE, MESSAGES_SET_TEXT_MODE_ON_MAX, ANY_TIME),
    RULE(TARE, ANY, NOT_CALIBRATING),
    RULE(TARE_CLEAR, ANY, NOT_CALIBRATING),
    RULE(ZERO, ANY, NOT_CALIBRATING),
    RULE(SHOW, MESSAGES_SHOW_VIEW_MAX, ANY_TIME),
    RULE(COUNT_PIECES, ANY, NOT_CALIBRATING),
    RULE(RESET_COUNTS, ANY, NOT_CALIBRATING),
    RULE(CALIBRATE_BEGIN, ANY, NOT_CALIBRATING),
    RULE(CALIBRATE_POINT, ANY, CALIBRATING),
    RULE(CALIBRATE_KNOWN, ANY, CALIBRATING),
    RULE(CALIBRATE_END, ANY, CALIBRATING),
    RULE(CALIBRATE_ABORT, ANY, CALIBRATING),
    RULE(GET_POINT, MESSAGES_GET_POINT_INDEX_MAX, ANY_TIME),
    RULE(GET_SETTING, ANY, ANY_TIME),
    RULE(SET_SETTING, ANY, NOT_CALIBRATING),
    RULE(SAVE_SETTINGS, ANY, NOT_CALIBRATING),
    RULE(RESET_SETTINGS, MESSAGES_RESET_SETTINGS_WHAT_MAX, NOT_CALIBRATING),
};

/* A payload, by the one field that its command begins with, or by all of them. */
typedef union {
    uint8_t                 first;
    messages_count_pieces_t pieces;
    messages_setting_t      setting; /* GET_SETTING and SET_SETTING are its head and all */
    messages_point_t        point;   /* GET_POINT is its head, CALIBRATE_... its tail */
} fields_t;

_Static_assert(sizeof(messages_point_t) - sizeof(messages_calibrate_known_t) ==
                       offsetof(messages_point_t, counts_q7) &&
                   sizeof(messages_point_t) - sizeof(messages_calibrate_point_t) ==
                       offsetof(messages_point_t, mass_mg) &&
                   offsetof(messages_calibrate_known_t, counts_q7) == 0,
               "CALIBRATE_KNOWN and CALIBRATE_POINT are the tail of a POINT");

_Static_assert(sizeof(messages_setting_t) == MESSAGES_SET_SETTING_LEN, "SET_SETTING is a SETTING");

/* Of no frame more is kept than a payload that fits. */
enum { KEPT = FRAME_HEADER_LEN + sizeof(fields_t) };

static uint8_t decoder_bytes[offsetof(frame_decoder_t, body) + KEPT];

static frame_decoder_t *the_decoder(void)
{
    return (frame_decoder_t *)decoder_bytes;
}

void command_init(void)
{
    frame_decoder_init(the_decoder(), KEPT);
    words_init();
}

static bool is_within(int32_t value, int32_t most)
{
    return value >= -most && value <= most;
}

_Static_assert(MESSAGES_CALIBRATE_POINT_MASS_MG_MIN == -MESSAGES_CALIBRATE_POINT_MASS_MG_MAX &&
                   MESSAGES_CALIBRATE_POINT_MASS_MG_MAX == MESSAGES_CALIBRATE_KNOWN_MASS_MG_MAX &&
                   MESSAGES_CALIBRATE_KNOWN_MASS_MG_MIN == -MESSAGES_CALIBRATE_KNOWN_MASS_MG_MAX &&
                   MESSAGES_CALIBRATE_KNOWN_COUNTS_Q7_MIN ==
                       -MESSAGES_CALIBRATE_KNOWN_COUNTS_Q7_MAX,
               "ranges are even");

/* Of the fields that the table says nothing of. */
static bool in_range(uint8_t id, const fields_t *fields)
{
    switch (id) {
    case MESSAGES_COUNT_PIECES_ID: return fields->pieces.pieces >= MESSAGES_COUNT_PIECES_PIECES_MIN;
    case MESSAGES_CALIBRATE_POINT_ID: /* its counts are 0 yet */
    case MESSAGES_CALIBRATE_KNOWN_ID:
        return is_within(fields->point.mass_mg, MESSAGES_CALIBRATE_KNOWN_MASS_MG_MAX) &&
               is_within(fields->point.counts_q7, MESSAGES_CALIBRATE_KNOWN_COUNTS_Q7_MAX);
    default: return true;
    }
}

/* Why a command is refused before it is tried. */
static uint8_t judge(uint8_t id, uint8_t len, const fields_t *fields)
{
    const rule_t *rule = rules;

    while (pgm_read_byte(&rule->id) != id) {
        if (++rule == &rules[sizeof rules / sizeof rules[0]]) {
            return MESSAGES_RESULT_UNKNOWN_COMMAND;
        }
    }
    if (pgm_read_byte(&rule->len) != len) { return MESSAGES_RESULT_WRONG_LENGTH; }
    if (len != 0U && fields->first > pgm_read_byte(&rule->most)) {
        return MESSAGES_RESULT_OUT_OF_RANGE;
    }
    if (!in_range(id, fields)) { return MESSAGES_RESULT_OUT_OF_RANGE; }
    const uint8_t time = pgm_read_byte(&rule->time);
    if (weighing_is_calibrating()) {
        return time == NOT_CALIBRATING ? MESSAGES_RESULT_CALIBRATING : MESSAGES_RESULT_OK;
    }
    return time == CALIBRATING ? MESSAGES_RESULT_NOT_CALIBRATING : MESSAGES_RESULT_OK;
}

/* Points and settings that are asked for come back in `fields`. */
static __attribute__((noinline)) uint8_t act(uint8_t id, fields_t *fields)
{
    switch (id) {
    case MESSAGES_SET_STREAM_ID: telemetry_set_stream(fields->first); break;
    case MESSAGES_SET_TEXT_MODE_ID: telemetry_set_text_mode(fields->first); break;
    case MESSAGES_TARE_ID: return weighing_tare();
    case MESSAGES_TARE_CLEAR_ID: return weighing_tare_clear();
    case MESSAGES_ZERO_ID: return weighing_zero();
    case MESSAGES_SHOW_ID: return weighing_view(fields->first);
    case MESSAGES_COUNT_PIECES_ID: return weighing_count_pieces(fields->pieces.pieces);
    case MESSAGES_RESET_COUNTS_ID: return weighing_reset_counts();
    case MESSAGES_CALIBRATE_BEGIN_ID: weighing_calibrate_begin(); break;
    case MESSAGES_CALIBRATE_POINT_ID: return weighing_calibrate_point(&fields->point);
    case MESSAGES_CALIBRATE_KNOWN_ID: return weighing_calibrate_known(&fields->point);
    case MESSAGES_CALIBRATE_END_ID: return weighing_calibrate_end();
    case MESSAGES_CALIBRATE_ABORT_ID: weighing_calibrate_abort(); break;
    case MESSAGES_GET_POINT_ID: return weighing_point(&fields->point);
    case MESSAGES_GET_SETTING_ID: return setup_get(fields->setting.key, &fields->setting.value);
    case MESSAGES_SET_SETTING_ID: return setup_set(fields->setting.key, fields->setting.value);
    case MESSAGES_SAVE_SETTINGS_ID: setup_save(); break;
    case MESSAGES_RESET_SETTINGS_ID: setup_reset(fields->first); break;
    default: break;
    }
    return MESSAGES_RESULT_OK;
}

static uint8_t run(uint8_t id, const uint8_t payload[], uint8_t len, fields_t *fields)
{
    uint8_t *to = (uint8_t *)fields;

    memset(fields, 0, sizeof *fields);
    if (id == MESSAGES_CALIBRATE_POINT_ID || id == MESSAGES_CALIBRATE_KNOWN_ID) {
        to += sizeof(messages_point_t) - len;
    }
    if (len <= sizeof *fields) { memcpy(to, payload, len); }
    const uint8_t refusal = judge(id, len, fields);

    return refusal == MESSAGES_RESULT_OK ? act(id, fields) : refusal;
}

uint8_t command_run(uint8_t id, uint8_t on)
{
    fields_t fields;

    return run(id, &on, id == MESSAGES_SET_TEXT_MODE_ID ? 1U : 0U, &fields);
}

void command_acknowledge(uint8_t id, uint8_t sequence, uint8_t result)
{
    const messages_ack_t ack = {.command = id, .command_sequence = sequence, .result = result};

    telemetry_answer(MESSAGES_ACK_ID, &ack, sizeof ack);
    if (result == MESSAGES_RESULT_OK && id == MESSAGES_GET_INFO_ID) {
        telemetry_hello();
        telemetry_status();
    }
}

static void run_frame(void)
{
    frame_t  frame;
    fields_t fields;

    frame_decoder_read(the_decoder(), &frame);
    const uint8_t result = run(frame.id, frame.payload, frame.payload_len, &fields);
    command_acknowledge(frame.id, frame.sequence, result);
    if (result != MESSAGES_RESULT_OK) { return; }
    switch (frame.id) {
    case MESSAGES_CALIBRATE_POINT_ID:
    case MESSAGES_CALIBRATE_KNOWN_ID:
    case MESSAGES_GET_POINT_ID:
        telemetry_answer(MESSAGES_POINT_ID, &fields.point, sizeof fields.point);
        break;
    case MESSAGES_GET_SETTING_ID:
    case MESSAGES_SET_SETTING_ID:
        telemetry_answer(MESSAGES_SETTING_ID, &fields.setting, sizeof fields.setting);
        break;
    default: break;
    }
}

void command_receive(uint8_t byte)
{
    switch (frame_decoder_push(the_decoder(), byte)) {
    case FRAME_READY: run_frame(); break;
    case FRAME_PENDING: break;
    case FRAME_BAD_COBS:
    case FRAME_BAD_LEN:
    case FRAME_BAD_CRC:
    default: telemetry_count_bad_rx(); break;
    }
    if (words_receive(byte)) { frame_decoder_init(the_decoder(), KEPT); }
}

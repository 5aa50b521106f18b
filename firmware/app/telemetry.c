/* SPDX-License-Identifier: MIT */
#include "telemetry.h"

#include "counter.h"
#include "frame.h"
#include "hx711.h"
#include "idle.h"
#include "led.h"
#include "stack.h"
#include "text.h"
#include "ticks.h"
#include "uart.h"
#include "version.h"
#include "watchdog.h"
#include "weighing.h"

#define SECOND_US 1000000UL

enum {
    FRAME_OVERHEAD = 1 + FRAME_WIRE_MAX - FRAME_PAYLOAD_MAX, /* with a delimiter before it */
    STREAM_LEAVES  = 0,
    /* Answers leave room for a STATUS and the longest sample, so that a host that asks without end
     * cannot keep out what is streamed. */
    ANSWERS_LEAVE = 32 + TEXT_LINE_MAX
};

/* The drivers know nothing of the wire; these say that both count alike. */
_Static_assert((int)HX711_STATE_SETTLING == (int)MESSAGES_CONVERTER_STATE_SETTLING &&
                   (int)HX711_STATE_RUNNING == (int)MESSAGES_CONVERTER_STATE_RUNNING &&
                   (int)HX711_STATE_TIMED_OUT == (int)MESSAGES_CONVERTER_STATE_TIMED_OUT &&
                   (int)HX711_STATE_BAD_FRAME == (int)MESSAGES_CONVERTER_STATE_BAD_FRAME,
               "converter_state in messages.toml");
_Static_assert((int)WATCHDOG_CAUSE_UNKNOWN == (int)MESSAGES_RESET_CAUSE_UNKNOWN &&
                   (int)WATCHDOG_CAUSE_POWER_ON == (int)MESSAGES_RESET_CAUSE_POWER_ON &&
                   (int)WATCHDOG_CAUSE_EXTERNAL == (int)MESSAGES_RESET_CAUSE_EXTERNAL &&
                   (int)WATCHDOG_CAUSE_BROWN_OUT == (int)MESSAGES_RESET_CAUSE_BROWN_OUT &&
                   (int)WATCHDOG_CAUSE_WATCHDOG == (int)MESSAGES_RESET_CAUSE_WATCHDOG,
               "reset_cause in messages.toml");

static uint8_t  stream_mask;
static bool     text_mode;
static bool     line_is_dirty; /* the receiver may hold bytes that are no frame's */
static uint8_t  sequence;
static uint16_t frames_dropped;
static uint16_t rx_bad_frames;
static uint32_t second_us; /* start of the present second */
static uint32_t closed_us; /* when the last one was closed, a little after its end */
static uint32_t uptime_s;
static uint16_t cpu_busy_permille; /* of the last whole second */
static uint16_t stack_free;        /* as of its end: counting takes too long to do on demand */

void telemetry_init(void)
{
    stream_mask   = MESSAGES_STREAM_FLAG_SAMPLE | MESSAGES_STREAM_FLAG_STATUS;
    stack_free    = stack_free_bytes();
    line_is_dirty = true; /* a boot loader may have spoken, or a torn frame before the reset */
}

/* True, and counted, if len bytes and then `leave` more do not fit in the transmit buffer. */
static bool refuse(uint8_t len, uint8_t leave)
{
    const bool full = (uint16_t)len + leave > uart_write_room();

    if (full) { counter_add(&frames_dropped, 1); }
    return full;
}

static void send(uint8_t id, uint32_t device_us, const uint8_t payload[], uint8_t payload_len,
                 uint8_t leave)
{
    uint8_t       wire[1 + FRAME_WIRE_MAX] = {0}; /* a delimiter, if one is needed, goes before */
    const frame_t frame                    = {.id          = id,
                                              .sequence    = sequence++,
                                              .device_us   = device_us,
                                              .payload_len = payload_len,
                                              .payload     = payload};
    const uint8_t head                     = (uint8_t)(line_is_dirty ? 0 : 1);

    if (refuse((uint8_t)(payload_len + FRAME_OVERHEAD), leave)) { return; }
    const uint8_t len = (uint8_t)(1U + frame_encode(&wire[1], &frame) - head);
    line_is_dirty     = !uart_write(&wire[head], len);
}

static void send_line(const text_line_t *line)
{
    line_is_dirty = true;
    uart_write((const uint8_t *)line->characters, line->len);
}

void telemetry_hello(void)
{
    const weighing_setup_t setup = weighing_setup();
    const messages_hello_t hello = {.protocol_fingerprint  = MESSAGES_FINGERPRINT,
                                    .version_major         = VERSION_MAJOR,
                                    .version_minor         = VERSION_MINOR,
                                    .version_patch         = VERSION_PATCH,
                                    .build                 = VERSION_BUILD,
                                    .reset_cause           = (uint8_t)watchdog_reset_cause(),
                                    .gain                  = hx711_gain(),
                                    .fir_design            = setup.fir_design,
                                    .fir_taps              = setup.fir_taps,
                                    .kf_schedule           = setup.kf_schedule,
                                    .converter_rate_hz_q16 = weighing_rate_hz_q16(),
                                    .chain_order           = setup.chain_order,
                                    .kf_kind               = setup.kf_kind};
    uint8_t                payload[MESSAGES_HELLO_LEN];

    send(MESSAGES_HELLO_ID, ticks_device_us(), payload, messages_hello_pack(payload, &hello),
         ANSWERS_LEAVE);
}

static void send_status(uint8_t leave)
{
    const hx711_counters_t   *converter = hx711_counters();
    const weighing_counters_t chain     = weighing_counters();
    const messages_status_t   status    = {.uptime_s              = uptime_s,
                                           .converter_state       = (uint8_t)hx711_state(),
                                           .converter_rate_hz_q16 = weighing_rate_hz_q16(),
                                           .conversions           = converter->conversions,
                                           .settling_dropped      = converter->settling_dropped,
                                           .converter_timeouts    = converter->timeouts,
                                           .converter_bad_frames  = converter->bad_frames,
                                           .conversions_missed    = chain.conversions_missed,
                                           .at_rail               = chain.at_rail,
                                           .fir_clipped           = chain.fir_clipped,
                                           .kf_clipped            = chain.kf_clipped,
                                           .tx_frames_dropped     = frames_dropped,
                                           .rx_overruns           = uart_rx_overruns(),
                                           .rx_bad_frames         = rx_bad_frames,
                                           .stack_free_bytes      = stack_free,
                                           .cpu_busy_permille     = cpu_busy_permille};
    uint8_t                   payload[MESSAGES_STATUS_LEN];

    send(MESSAGES_STATUS_ID, ticks_device_us(), payload, messages_status_pack(payload, &status),
         leave);
}

void telemetry_status(void)
{
    send_status(ANSWERS_LEAVE);
}

void telemetry_ack(const messages_ack_t *ack)
{
    uint8_t payload[MESSAGES_ACK_LEN];

    send(MESSAGES_ACK_ID, ticks_device_us(), payload, messages_ack_pack(payload, ack),
         ANSWERS_LEAVE);
}

void telemetry_sample(const messages_sample_t *sample, uint32_t device_us)
{
    if ((stream_mask & MESSAGES_STREAM_FLAG_SAMPLE) == 0U) { return; }
    if (text_mode) {
        text_line_t line;
        if (refuse(TEXT_LINE_MAX, STREAM_LEAVES)) { return; }
        text_sample(&line, sample);
        send_line(&line);
    } else {
        uint8_t payload[MESSAGES_SAMPLE_LEN];
        send(MESSAGES_SAMPLE_ID, device_us, payload, messages_sample_pack(payload, sample),
             STREAM_LEAVES);
    }
}

static void close_second(uint32_t elapsed_us)
{
    const uint32_t slept_us      = idle_take_slept_ticks() / 2U; /* ticks of 0.5 us */
    const uint32_t busy_us       = slept_us < elapsed_us ? elapsed_us - slept_us : 0U;
    const uint32_t permille_busy = busy_us / (elapsed_us / 1000U);

    cpu_busy_permille = (uint16_t)permille_busy; /* <= 1001 */
    stack_free        = stack_free_bytes();
    if (uptime_s != UINT32_MAX) { uptime_s++; }
}

/* Whole, for the tests that hold the main loop up break in here. */
__attribute__((noinline)) void telemetry_tick(uint32_t now_us)
{
    if (now_us - second_us < SECOND_US) { return; }
    second_us += SECOND_US;
    close_second(now_us - closed_us);
    closed_us = now_us;

    led_set(hx711_state() != HX711_STATE_RUNNING || (uptime_s & 1U) != 0U);
    if ((stream_mask & MESSAGES_STREAM_FLAG_STATUS) != 0U && !text_mode) {
        send_status(STREAM_LEAVES);
    }
}

void telemetry_info_lines(void)
{
    text_line_t line;

    if (refuse(2 * TEXT_LINE_MAX, ANSWERS_LEAVE)) { return; }
    text_version(&line);
    send_line(&line);
    text_converter(&line, hx711_gain(), weighing_rate_hz_q16());
    send_line(&line);
}

void telemetry_answer_line(const char *word, uint8_t result)
{
    text_line_t line;

    if (refuse(TEXT_LINE_MAX, ANSWERS_LEAVE)) { return; }
    text_answer(&line, word, result);
    send_line(&line);
}

void telemetry_set_stream(uint8_t mask)
{
    stream_mask = mask;
}

void telemetry_set_text_mode(bool on)
{
    text_mode = on;
}

bool telemetry_text_mode(void)
{
    return text_mode;
}

void telemetry_count_bad_rx(void)
{
    counter_add(&rx_bad_frames, 1);
}

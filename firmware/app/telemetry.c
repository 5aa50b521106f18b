/* SPDX-License-Identifier: MIT */
#include "telemetry.h"

#include "attitude.h"
#include "counter.h"
#include "frame.h"
#include "health.h"
#include "hx711.h"
#include "idle.h"
#include "port_outline.h"
#include "port_reach.h"
#include "port_wide.h"
#include "setup.h"
#include "stack.h"
#include "store.h"
#include "text.h"
#include "ticks.h"
#include "uart.h"
#include "version.h"
#include "watchdog.h"
#include "weighing.h"

#include <stddef.h>
#include <string.h>

#define SECOND_US    1000000UL
#define WEIGHT_256US 391U /* 10 a second */

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

/* This chip is little-endian and pads nothing: a message lies in memory as it does on the wire. */
_Static_assert(sizeof(messages_hello_t) == MESSAGES_HELLO_LEN &&
                   sizeof(messages_status_t) == MESSAGES_STATUS_LEN &&
                   sizeof(messages_sample_t) == MESSAGES_SAMPLE_LEN &&
                   sizeof(messages_weight_t) == MESSAGES_WEIGHT_LEN,
               "no padding");

/* Counters stand in STATUS as their owners have them, in the same order. */
_Static_assert(sizeof(hx711_counters_t) == offsetof(messages_status_t, conversions_missed) -
                                               offsetof(messages_status_t, conversions) &&
                   sizeof(weighing_counters_t) ==
                       offsetof(messages_status_t, rx_overruns) -
                           offsetof(messages_status_t, conversions_missed) &&
                   offsetof(messages_status_t, converter_bad_frames) -
                           offsetof(messages_status_t, conversions) ==
                       offsetof(hx711_counters_t, bad_frames) &&
                   offsetof(messages_status_t, kf_clipped) -
                           offsetof(messages_status_t, conversions_missed) ==
                       offsetof(weighing_counters_t, kf_clipped),
               "STATUS");

typedef struct {
    /* The head of STATUS. */
    uint32_t uptime_s;
    uint16_t frames_dropped;
    uint16_t rx_bad_frames;
    uint16_t stack_free; /* as of the last second's end: counting takes too long to do on demand */
    uint16_t cpu_busy_permille; /* of the last whole second */

    uint32_t second_us;    /* start of the present second */
    uint32_t closed_us;    /* when the last one was closed, a little after its end */
    uint16_t weight_256us; /* when the last WEIGHT went out */
    uint8_t  weight_flags; /* as told by it */
    bool     stream_lost;  /* in the present second something streamed did not fit */
} telemetry_t;

static telemetry_t own;
static uint8_t     stream_mask;
static uint8_t     text_mode; /* 0 or 1 */
static uint8_t     sequence;
static bool        line_is_dirty; /* the receiver may hold bytes that are no frame's */

_Static_assert(offsetof(messages_status_t, uptime_s) == 0 &&
                   offsetof(messages_status_t, cpu_busy_permille) ==
                       offsetof(telemetry_t, cpu_busy_permille),
               "STATUS begins with these");
_Static_assert(offsetof(telemetry_t, second_us) == 12, "hil_tests set the clock");

void telemetry_init(void)
{
    stream_mask    = setup.stream_mask;
    text_mode      = setup.text_mode;
    own.stack_free = stack_free_bytes();
    line_is_dirty  = true; /* a boot loader may have spoken, or a torn frame before the reset */
}

/* True, and counted, if len bytes and then `leave` more do not fit in the transmit buffer. */
static bool refuse(uint8_t len, uint8_t leave)
{
    const bool full = (uint16_t)len + leave > uart_write_room();

    if (full) { counter_add(&own.frames_dropped, 1); }
    if (full && leave == STREAM_LEAVES) { own.stream_lost = true; }
    return full;
}

static PORT_OUTLINE void send(uint8_t id, uint32_t device_us, const void *payload,
                              uint8_t payload_len, uint8_t leave)
{
    const frame_t frame = {.id          = id,
                           .sequence    = sequence++,
                           .device_us   = device_us,
                           .payload_len = payload_len,
                           .payload     = payload};

    if (refuse((uint8_t)(payload_len + FRAME_OVERHEAD), leave)) { return; }
    uint8_t at = uart_begin();
    if (line_is_dirty) { uart_tx_ring[at++] = 0U; } /* a delimiter */
    line_is_dirty = false;
    uart_end(frame_encode(uart_tx_ring, at, &frame));
}

void telemetry_stream(uint8_t flag, uint8_t id, uint32_t device_us, const void *payload,
                      uint8_t len)
{
    if (text_mode != 0U || (stream_mask & flag) == 0U) { return; }
    send(id, device_us, payload, len, STREAM_LEAVES);
}

void telemetry_answer(uint8_t id, const void *message, uint8_t len)
{
    send(id, ticks_device_us(), message, len, ANSWERS_LEAVE);
}

PORT_OUTLINE void telemetry_hello(void)
{
    const messages_hello_t hello = {.protocol_fingerprint  = MESSAGES_FINGERPRINT,
                                    .version_major         = VERSION_MAJOR,
                                    .version_minor         = VERSION_MINOR,
                                    .version_patch         = VERSION_PATCH,
                                    .build                 = VERSION_BUILD,
                                    .reset_cause           = (uint8_t)watchdog_reset_cause(),
                                    .gain                  = hx711_gain(),
                                    .fir_design            = WEIGHING_FIR_DESIGN,
                                    .fir_taps              = WEIGHING_FIR_TAPS,
                                    .kf_schedule           = WEIGHING_KF_SCHEDULE,
                                    .converter_rate_hz_q16 = weighing_rate_hz_q16(),
                                    .chain_order           = setup.chain_order,
                                    .kf_kind               = MESSAGES_KF_KIND_ADAPTIVE};

    telemetry_answer(MESSAGES_HELLO_ID, &hello, sizeof hello);
}

static PORT_OUTLINE void send_status(uint8_t leave)
{
    messages_status_t status;

    memcpy(&status, &own, offsetof(telemetry_t, second_us));
    status.converter_state       = (uint8_t)hx711_state();
    status.converter_rate_hz_q16 = weighing_rate_hz_q16();
    memcpy(&status.conversions, hx711_counters(), sizeof(hx711_counters_t));
    memcpy(&status.conversions_missed, weighing_counters(), sizeof(weighing_counters_t));
    status.rx_overruns    = uart_rx_overruns();
    status.faults         = health_faults();
    status.faults_seen    = health_seen();
    status.settings_state = store_state();
    status.settings_saved = store_sequence();
    send(MESSAGES_STATUS_ID, ticks_device_us(), &status, sizeof status, leave);
}

void telemetry_status(void)
{
    send_status(ANSWERS_LEAVE);
}

static PORT_OUTLINE void stream_weight(uint32_t now_us)
{
    messages_weight_t weight;

    weighing_show(&weight);
    weight.faults    = health_faults();
    own.weight_flags = weight.weight_flags;
    own.weight_256us = (uint16_t)(now_us >> 8);
    telemetry_stream(MESSAGES_STREAM_FLAG_WEIGHT, MESSAGES_WEIGHT_ID, now_us, &weight,
                     sizeof weight);
}

static void stream_events(void)
{
    union {
        messages_step_t    step;
        messages_product_t product;
    } event;
    uint32_t device_us;

    if (weighing_step(&event.step, &device_us)) {
        telemetry_stream(MESSAGES_STREAM_FLAG_EVENT, MESSAGES_STEP_ID, device_us, &event.step,
                         sizeof event.step);
    }
    if (weighing_product(&event.product, &device_us)) {
        telemetry_stream(MESSAGES_STREAM_FLAG_EVENT, MESSAGES_PRODUCT_ID, device_us, &event.product,
                         sizeof event.product);
    }
}

/* Lines go out as they are made: first there must be room for so many, and others' answers. */
static PORT_OUTLINE bool refuse_lines(uint8_t lines_len, uint8_t leave)
{
    line_is_dirty = true;
    return refuse(lines_len, leave);
}

void telemetry_sample(const messages_sample_t *sample, uint32_t device_us)
{
    if (text_mode != 0U && (stream_mask & MESSAGES_STREAM_FLAG_SAMPLE) != 0U) {
        if (!refuse_lines(TEXT_LINE_MAX, STREAM_LEAVES)) { text_sample(sample); }
        return;
    }
    telemetry_stream(MESSAGES_STREAM_FLAG_SAMPLE, MESSAGES_SAMPLE_ID, device_us, sample,
                     sizeof *sample);
    if (sample->weight_flags != own.weight_flags) { stream_weight(device_us); }
    stream_events();
}

static void close_second(telemetry_t *it, uint32_t elapsed_us)
{
    const uint32_t slept_us = idle_take_slept_ticks() / 2U; /* ticks of 0.5 us */
    const uint32_t busy_us  = slept_us < elapsed_us ? elapsed_us - slept_us : 0U;

    it->cpu_busy_permille = /* a share just below 1 where nothing was slept */
        (uint16_t)port_wide_high(port_wide_ratio(busy_us, elapsed_us), 1000U);
    it->stack_free = stack_free_bytes();
    it->uptime_s++; /* for 136 years */
    health_note_one(MESSAGES_FAULT_FLAG_TELEMETRY_LOST, it->stream_lost);
    it->stream_lost = false;
}

/* Whole, for the tests that hold the main loop up break in here. */
PORT_OUTLINE void telemetry_tick(uint32_t now_us)
{
    telemetry_t *const it = PORT_REACH(&own);

    if (now_us - it->second_us >= SECOND_US) {
        it->second_us += SECOND_US;
        close_second(it, now_us - it->closed_us);
        it->closed_us = now_us;
        if ((stream_mask & MESSAGES_STREAM_FLAG_STATUS) != 0U && text_mode == 0U) {
            send_status(STREAM_LEAVES);
        }
        attitude_tick();
    }
    if ((uint16_t)((uint16_t)(now_us >> 8) - it->weight_256us) >= WEIGHT_256US) {
        stream_weight(now_us);
    }

    const uint16_t changed = health_take_changed();
    if (changed != 0U) {
        const messages_fault_t fault = {.faults = health_faults(), .changed = changed};
        telemetry_stream(MESSAGES_STREAM_FLAG_EVENT, MESSAGES_FAULT_ID, now_us, &fault,
                         sizeof fault);
    }
}

void telemetry_info_lines(void)
{
    if (refuse_lines(2 * TEXT_LINE_MAX, TEXT_LINE_MAX)) { return; }
    text_version();
    text_converter(hx711_gain(), weighing_rate_hz_q16());
}

void telemetry_answer_line(const char *word, uint8_t result)
{
    if (!refuse_lines(TEXT_LINE_MAX, TEXT_LINE_MAX)) { text_answer(word, result); }
}

void telemetry_set_stream(uint8_t mask)
{
    stream_mask = mask;
}

void telemetry_set_text_mode(uint8_t on)
{
    text_mode = on;
}

bool telemetry_text_mode(void)
{
    return text_mode != 0U;
}

void telemetry_count_bad_rx(void)
{
    counter_add(&own.rx_bad_frames, 1);
}

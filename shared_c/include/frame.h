/* SPDX-License-Identifier: MIT */
/* frame - one message on the wire: COBS(id, sequence, device_us, payload, crc) 0x00.
 *
 * Model     Cheshire and Baker 1999 (COBS); CRC-16/MCRF4XX, check value 0x6F91 over "123456789",
 *           sent low byte first. Layout and messages: shared_c/PROTOCOL.md
 * Formats   bodies are shorter than 254 bytes, so that COBS adds one byte, exactly
 * Bad data  the decoder never fails: it says what was wrong with a body and takes up again at the
 *           next 0x00, whatever bytes it is fed. Two 0x00 in a row are an idle line, not an error.
 * Context   one encoder or decoder has one caller; not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef FRAME_H
#define FRAME_H

#include <stdint.h>

enum {
    FRAME_PAYLOAD_MAX = 48,
    FRAME_HEADER_LEN  = 6, /* id, sequence, device_us */
    FRAME_CRC_LEN     = 2,
    FRAME_BODY_MAX    = FRAME_HEADER_LEN + FRAME_PAYLOAD_MAX + FRAME_CRC_LEN,
    FRAME_WIRE_MAX    = FRAME_BODY_MAX + 2 /* COBS code byte and delimiter */
};

typedef struct {
    uint8_t        id;
    uint8_t        sequence;    /* frames of this sender, modulo 256 */
    uint32_t       device_us;   /* the device's clock; 0 from a host */
    uint8_t        payload_len; /* 0..FRAME_PAYLOAD_MAX */
    const uint8_t *payload;     /* the sender's bytes, or inside the decoder that gave the frame */
} frame_t;

typedef enum {
    FRAME_PENDING,  /* go on */
    FRAME_READY,    /* frame_decoder_read gives a good one until the next push */
    FRAME_BAD_COBS, /* a code byte points past the delimiter */
    FRAME_BAD_LEN,  /* shorter than header and CRC, or longer than FRAME_BODY_MAX */
    FRAME_BAD_CRC
} frame_status_t;

typedef struct {
    uint16_t crc;                  /* of the body so far */
    uint8_t  keeps;                /* bytes of a body */
    uint8_t  body_len;             /* decoded so far, 0..FRAME_BODY_MAX */
    uint8_t  block_left;           /* bytes until the next COBS code byte; 0: expects one */
    uint8_t  flags;                /* see frame.c */
    uint8_t  body[FRAME_BODY_MAX]; /* its first bytes, so many as are kept */
} frame_decoder_t;

/* Write the frame's bytes, at most FRAME_WIRE_MAX, delimiter included, into a ring of 256 from
 * place `at` on; gives the place behind them. From 0 on any FRAME_WIRE_MAX bytes will do, and that
 * is the frame's length. payload_len beyond FRAME_PAYLOAD_MAX is a wiring mistake (assert). */
uint8_t frame_encode(uint8_t ring[], uint8_t at, const frame_t *frame);

/* To keep the first `keeps` bytes of a body, FRAME_HEADER_LEN at least: behind them the decoder may
 * end. What is longer is judged all the same, and its payload cut off. */
void           frame_decoder_init(frame_decoder_t *decoder, uint8_t keeps);
frame_status_t frame_decoder_push(frame_decoder_t *decoder, uint8_t byte);

/* The frame that the last push completed. Its payload lies in decoder->body: use it before the
 * next push. */
void frame_decoder_read(const frame_decoder_t *decoder, frame_t *frame);

/* CRC-16/MCRF4XX of len bytes, started at 0xFFFF. */
uint16_t frame_crc16(const uint8_t bytes[], uint8_t len);

#endif

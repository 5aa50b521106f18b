/* SPDX-License-Identifier: MIT */
#include "frame.h"

#include <stdbool.h>

#include "port_assert.h"
#include "port_crc.h"

enum {
    DELIMITER = 0x00,
    CODE_MAX  = 0xFF, /* a block of 254 bytes that no zero ends, COBS table 1 */
    PARTS     = 3,    /* header, payload, CRC */

    FLAG_STARTED = 1U << 0, /* a code byte has been seen since the delimiter */
    FLAG_ZERO    = 1U << 1, /* the block that is being read ends in a zero, if another follows */
    FLAG_LONG    = 1U << 2, /* the body has more than FRAME_BODY_MAX bytes */
};

_Static_assert(FRAME_BODY_MAX < 254, "one COBS code byte a zero, none for length");

uint8_t frame_encode(uint8_t ring[], uint8_t at, const frame_t *frame)
{
    uint8_t        head[FRAME_HEADER_LEN] = {frame->id, frame->sequence};
    const uint8_t *from                   = head;
    uint8_t        left                   = FRAME_HEADER_LEN;
    uint32_t       clock                  = frame->device_us;
    uint16_t       crc                    = PORT_CRC16_START;
    uint8_t        code_at                = at++; /* a block's code byte; where its zero was */

    PORT_ASSERT(frame->payload_len <= FRAME_PAYLOAD_MAX);
    for (uint8_t byte = 2U; byte < FRAME_HEADER_LEN; ++byte, clock >>= 8) {
        head[byte] = (uint8_t)clock;
    }
    for (uint8_t part = PARTS;;) {
        for (; left != 0U; --left) {
            const uint8_t byte = *from++;
            crc                = port_crc16(crc, byte);
            ring[at]           = byte;
            if (byte == DELIMITER) {
                ring[code_at] = (uint8_t)(at - code_at);
                code_at       = at;
            }
            ++at;
        }
        if (--part == 0U) { break; }
        from = frame->payload;
        left = frame->payload_len;
        if (part == 1U) {
            head[0] = (uint8_t)crc;
            head[1] = (uint8_t)(crc >> 8);
            from    = head;
            left    = FRAME_CRC_LEN;
        }
    }
    ring[code_at] = (uint8_t)(at - code_at);
    ring[at++]    = DELIMITER;
    return at;
}

void frame_decoder_init(frame_decoder_t *decoder, uint8_t keeps)
{
    decoder->keeps      = keeps;
    decoder->body_len   = 0U;
    decoder->block_left = 0U;
    decoder->flags      = 0U;
}

static void take(frame_decoder_t *decoder, uint8_t byte)
{
    const uint8_t at = decoder->body_len;

    decoder->crc = port_crc16(decoder->crc, byte);
    if (at < decoder->keeps) { decoder->body[at] = byte; }
    if (at < FRAME_BODY_MAX) {
        decoder->body_len = (uint8_t)(at + 1U);
    } else {
        decoder->flags |= FLAG_LONG;
    }
}

static frame_status_t judge(const frame_decoder_t *decoder)
{
    if (decoder->block_left != 0U) { return FRAME_BAD_COBS; }
    if ((decoder->flags & FLAG_LONG) != 0U ||
        decoder->body_len < FRAME_HEADER_LEN + FRAME_CRC_LEN) {
        return FRAME_BAD_LEN;
    }
    /* The CRC of bytes followed by their own CRC, low byte first, is 0. */
    return decoder->crc == 0U ? FRAME_READY : FRAME_BAD_CRC;
}

frame_status_t frame_decoder_push(frame_decoder_t *decoder, uint8_t byte)
{
    if (byte == DELIMITER) {
        const bool           idle   = (decoder->flags & FLAG_STARTED) == 0U;
        const frame_status_t status = idle ? FRAME_PENDING : judge(decoder);

        decoder->block_left = 0U;
        decoder->flags      = 0U; /* body_len stays for frame_decoder_read */
        return status;
    }
    if ((decoder->flags & FLAG_STARTED) == 0U) {
        decoder->body_len = 0U;
        decoder->crc      = PORT_CRC16_START;
        decoder->flags    = FLAG_STARTED;
    }
    if (decoder->block_left != 0U) {
        --decoder->block_left;
        take(decoder, byte);
        return FRAME_PENDING;
    }
    /* A code byte. The block before it ended in a zero, unless it was the first or a full one. */
    if ((decoder->flags & FLAG_ZERO) != 0U) { take(decoder, DELIMITER); }
    decoder->block_left = (uint8_t)(byte - 1U);
    decoder->flags |= FLAG_ZERO;
    if (byte == CODE_MAX) { decoder->flags &= (uint8_t)~FLAG_ZERO; }
    return FRAME_PENDING;
}

static uint32_t read_u32(const uint8_t bytes[])
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

void frame_decoder_read(const frame_decoder_t *decoder, frame_t *frame)
{
    frame->id          = decoder->body[0];
    frame->sequence    = decoder->body[1];
    frame->device_us   = read_u32(&decoder->body[2]);
    frame->payload_len = (uint8_t)(decoder->body_len - FRAME_HEADER_LEN - FRAME_CRC_LEN);
    frame->payload     = &decoder->body[FRAME_HEADER_LEN];
}

uint16_t frame_crc16(const uint8_t bytes[], uint8_t len)
{
    uint16_t crc = PORT_CRC16_START;

    for (uint8_t at = 0U; at < len; ++at) { crc = port_crc16(crc, bytes[at]); }
    return crc;
}

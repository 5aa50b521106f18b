/* SPDX-License-Identifier: MIT */
/* runner - serves the filters, the frame and, elsewhere, the inertial modules. */
#include "runner.h"
#include "fir.h"
#include "fir_designs.h"
#include "frame.h"
#include "mass.h"
#include "runner_adaptive.h"
#include "runner_imu.h"
#include "runner_mahony.h"
#include "weight_kf.h"
#include "weight_kf_gains.h"

#include <string.h>

enum {
    OP_FIR_LOAD         = 'a', /* taps u8, half i16 each -> accepted u8 */
    OP_FIR_INIT         = 'f', /* design u8 (DESIGN_LOADED: the one loaded last), first i32 */
    OP_FIR_UPDATE       = 'F', /* n x sample i32 -> n x result i32 */
    OP_FIR_UPDATE_QUICK = 'q', /* the same by fir_update_default */
    OP_FIR_CLIPPED      = 'c', /* -> u16 */
    OP_WEIGHT_KF_INIT   = 'k', /* schedule u8, first i32 */
    OP_WEIGHT_KF_UPDATE = 'K', /* n x measurement i32 -> n x estimate i32 */
    OP_WEIGHT_KF_CLIP   = 'l', /* -> u16 */
    OP_MASS             = 'M', /* net i32, span u32 -> i32 */
    OP_CRC              = 'C', /* bytes -> u16 */
    OP_ENCODE           = 'E', /* id, sequence, device_us u32, payload -> wire bytes */
    OP_DECODE_INIT      = 'd',
    OP_DECODE           = 'D', /* bytes -> one frame_status_t a byte */
    OP_DECODED          = 'g', /* -> id, sequence, device_us u32, payload of the frame just ready */
    DESIGN_LOADED       = 255
};

static const weight_kf_config_t *const kf_configs[] = {
    [WEIGHT_KF_SCHEDULE_DEFAULT] = &weight_kf_default,
    [WEIGHT_KF_SCHEDULE_AVERAGE] = &weight_kf_average,
};

static fir_t           fir;
static int16_t         fir_half_q15[FIR_HALF_MAX];
static fir_config_t    fir_loaded;
static weight_kf_t     kf;
static frame_decoder_t decoder;

static int32_t get_i32(const uint8_t *bytes)
{
    int32_t value;
    memcpy(&value, bytes, sizeof value);
    return value;
}

static void put_i32(uint8_t *bytes, int32_t value)
{
    memcpy(bytes, &value, sizeof value);
}

static uint8_t put_u16(uint8_t buffer[], uint16_t value)
{
    memcpy(buffer, &value, sizeof value);
    return sizeof value;
}

static uint8_t load_fir(uint8_t buffer[], uint8_t len)
{
    const uint8_t sent = (uint8_t)(len - 1U); /* more than there is room for: to be refused */
    memcpy(fir_half_q15, &buffer[1], sent < sizeof fir_half_q15 ? sent : sizeof fir_half_q15);
    buffer[0] = fir_load(&fir_loaded, fir_half_q15, buffer[0]);
    return 1;
}

static void init_fir(const uint8_t buffer[])
{
    const uint8_t design = buffer[0];
    fir_init(&fir, design == DESIGN_LOADED ? &fir_loaded : fir_designs[design],
             get_i32(&buffer[1]));
}

static uint8_t encode(uint8_t buffer[], uint8_t len)
{
    uint8_t wire[FRAME_WIRE_MAX];
    frame_t frame = {.id = buffer[0], .sequence = buffer[1], .payload = &buffer[FRAME_HEADER_LEN]};
    memcpy(&frame.device_us, &buffer[2], sizeof frame.device_us);
    frame.payload_len      = (uint8_t)(len - FRAME_HEADER_LEN);
    const uint8_t wire_len = frame_encode(wire, 0, &frame);
    memcpy(buffer, wire, wire_len);
    return wire_len;
}

static uint8_t decoded(uint8_t buffer[])
{
    frame_t frame;
    frame_decoder_read(&decoder, &frame);
    buffer[0] = frame.id;
    buffer[1] = frame.sequence;
    memcpy(&buffer[2], &frame.device_us, sizeof frame.device_us);
    memcpy(&buffer[FRAME_HEADER_LEN], frame.payload, frame.payload_len);
    return (uint8_t)(FRAME_HEADER_LEN + frame.payload_len);
}

uint8_t runner_serve(uint8_t op, uint8_t buffer[], uint8_t len)
{
    switch (op) {
    case OP_FIR_LOAD: return load_fir(buffer, len);
    case OP_FIR_INIT: init_fir(buffer); return 0;
    case OP_FIR_UPDATE:
        for (uint8_t i = 0; i < len; i = (uint8_t)(i + 4U)) {
            put_i32(&buffer[i], fir_update(&fir, get_i32(&buffer[i])));
        }
        return len;
    case OP_FIR_UPDATE_QUICK:
        for (uint8_t i = 0; i < len; i = (uint8_t)(i + 4U)) {
            put_i32(&buffer[i], fir_update_default(&fir, get_i32(&buffer[i])));
        }
        return len;
    case OP_FIR_CLIPPED: return put_u16(buffer, fir.clipped);
    case OP_WEIGHT_KF_INIT:
        weight_kf_init(&kf, kf_configs[buffer[0]], get_i32(&buffer[1]));
        return 0;
    case OP_WEIGHT_KF_UPDATE:
        for (uint8_t i = 0; i < len; i = (uint8_t)(i + 4U)) {
            put_i32(&buffer[i], weight_kf_update(&kf, get_i32(&buffer[i])));
        }
        return len;
    case OP_WEIGHT_KF_CLIP: return put_u16(buffer, kf.clipped);
    case OP_MASS:
        put_i32(buffer, mass_from_counts(get_i32(buffer), (uint32_t)get_i32(&buffer[4])));
        return 4;
    case OP_CRC: return put_u16(buffer, frame_crc16(buffer, len));
    case OP_ENCODE: return encode(buffer, len);
    case OP_DECODE_INIT: frame_decoder_init(&decoder, FRAME_BODY_MAX); return 0;
    case OP_DECODE:
        for (uint8_t i = 0; i < len; i++) {
            buffer[i] = (uint8_t)frame_decoder_push(&decoder, buffer[i]);
        }
        return len;
    case OP_DECODED: return decoded(buffer);
    case OP_ADAPTIVE_INIT:
    case OP_ADAPTIVE_UPDATE:
    case OP_PAIR_INIT:
    case OP_PAIR_UPDATE:
    case OP_ADAPTIVE_CLIP: return runner_adaptive_serve(op, buffer, len);
    default:
        return op <= '9' ? runner_mahony_serve(op, buffer, len) : runner_imu_serve(op, buffer, len);
    }
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "uno_internal.h"

#include <string.h>

enum {
    TWBR_ADDR = 0xB8,
    TWSR_ADDR = 0xB9,
    TWDR_ADDR = 0xBB,
    TWCR_ADDR = 0xBC,

    TWINT = 0x80, /* TWCR */
    TWEA  = 0x40,
    TWSTA = 0x20,
    TWSTO = 0x10,
    TWEN  = 0x04,
    TWIE  = 0x01,

    BYTE_BITS = 9, /* with the acknowledge */
};

/* Status codes, tables 22-2 and 22-3. */
enum {
    S_START      = 0x08,
    S_RESTART    = 0x10,
    S_WRITE_ACK  = 0x18,
    S_WRITE_NACK = 0x20,
    S_SENT_ACK   = 0x28,
    S_SENT_NACK  = 0x30,
    S_READ_ACK   = 0x40,
    S_READ_NACK  = 0x48,
    S_GOT_ACKED  = 0x50,
    S_GOT_NACKED = 0x58,
    S_NOTHING    = 0xF8
};

enum { PHASE_IDLE, PHASE_STARTED, PHASE_ADDRESSED };
enum { ACT_NONE, ACT_START, ACT_STOP, ACT_ADDRESS, ACT_SEND, ACT_RECEIVE };

static uint64_t bit_cycles(const avr_t *avr) /* section 22.5.2 */
{
    const uint8_t prescaler_log4 = avr->data[TWSR_ADDR] & 3U;

    return 16U + (2ULL * avr->data[TWBR_ADDR] << (2U * prescaler_log4));
}

static void status(uno_t *uno, uint8_t code, bool interrupt)
{
    avr_t *avr = uno->avr;

    avr->data[TWSR_ADDR] = (uint8_t)((avr->data[TWSR_ADDR] & 3U) | code);
    if (interrupt) {
        avr_raise_interrupt(avr, &uno->twi.simavr->twi);
        avr->data[TWCR_ADDR] |= TWINT;
    }
}

static void finish_address(uno_t *uno)
{
    twi_t        *twi    = &uno->twi;
    const uint8_t sla_rw = uno->avr->data[TWDR_ADDR];

    twi->reading  = sla_rw & 1U;
    twi->selected = NULL;
    for (uint8_t i = 0; i < twi->device_count; i++) {
        twi_device_t *device = &twi->devices[i];
        if (device->address == sla_rw >> 1 && device->start(device->ctx, twi->reading)) {
            twi->selected = device;
        }
    }
    twi->phase = PHASE_ADDRESSED;
    uno->stats.twi_bytes++;
    if (!twi->selected) { uno->stats.twi_nacks++; }
    if (twi->reading) {
        status(uno, twi->selected ? S_READ_ACK : S_READ_NACK, true);
    } else {
        status(uno, twi->selected ? S_WRITE_ACK : S_WRITE_NACK, true);
    }
}

static void finish_send(uno_t *uno)
{
    twi_t     *twi   = &uno->twi;
    const bool acked = twi->selected &&
                       twi->selected->write(twi->selected->ctx, uno->avr->data[TWDR_ADDR]);

    uno->stats.twi_bytes++;
    if (!acked) { uno->stats.twi_nacks++; }
    status(uno, acked ? S_SENT_ACK : S_SENT_NACK, true);
}

static void finish_receive(uno_t *uno)
{
    twi_t        *twi = &uno->twi;
    const uint8_t cr  = uno->avr->data[TWCR_ADDR];

    uno->avr->data[TWDR_ADDR] = twi->selected ? twi->selected->read(twi->selected->ctx) : 0xFF;
    uno->stats.twi_bytes++;
    status(uno, (cr & TWEA) ? S_GOT_ACKED : S_GOT_NACKED, true);
}

static avr_cycle_count_t action_done(avr_t *avr, avr_cycle_count_t when, void *param)
{
    uno_t        *uno    = param;
    twi_t        *twi    = &uno->twi;
    const uint8_t action = twi->action;

    twi->action = ACT_NONE;
    switch (action) {
    case ACT_STOP:
        avr->data[TWCR_ADDR] &= (uint8_t)~TWSTO;
        twi->phase    = PHASE_IDLE;
        twi->selected = NULL;
        status(uno, S_NOTHING, false);
        if (twi->restart) {
            twi->action = ACT_START;
            return when + bit_cycles(avr);
        }
        break;
    case ACT_START:
        uno->stats.twi_starts++;
        status(uno, twi->phase == PHASE_IDLE ? S_START : S_RESTART, true);
        twi->phase = PHASE_STARTED;
        break;
    case ACT_ADDRESS: finish_address(uno); break;
    case ACT_SEND: finish_send(uno); break;
    case ACT_RECEIVE: finish_receive(uno); break;
    default: break;
    }
    return 0;
}

static void begin(uno_t *uno, uint8_t action, uint64_t cycles)
{
    uno->twi.action = action;
    avr_cycle_timer_register(uno->avr, cycles, action_done, uno);
}

static void disable(uno_t *uno, uint8_t v)
{
    avr_t *avr = uno->avr;

    avr_cycle_timer_cancel(avr, action_done, uno);
    uno->twi.action   = ACT_NONE;
    uno->twi.phase    = PHASE_IDLE;
    uno->twi.selected = NULL;
    avr_clear_interrupt(avr, &uno->twi.simavr->twi);
    avr->data[TWCR_ADDR] = v & (TWEA | TWIE);
    status(uno, S_NOTHING, false);
}

static void twcr_write(avr_t *avr, avr_io_addr_t addr, uint8_t v, void *param)
{
    uno_t         *uno  = param;
    twi_t         *twi  = &uno->twi;
    const uint8_t  flag = avr->data[addr] & TWINT;
    const uint64_t bit  = bit_cycles(avr);

    if (!(v & TWEN)) {
        disable(uno, v);
        return;
    }
    avr->data[addr] = (uint8_t)((v & (TWEA | TWSTA | TWSTO | TWEN | TWIE)) |
                                ((v & TWINT) ? 0U : flag));
    if (v & TWINT) {
        avr_clear_interrupt(avr, &twi->simavr->twi);
    } else if (flag) {
        if (v & TWIE) { avr_raise_interrupt(avr, &twi->simavr->twi); }
        return; /* the bus waits for the flag to be cleared */
    }
    if (twi->action != ACT_NONE) { return; }
    if (v & TWSTO) {
        twi->restart = v & TWSTA;
        begin(uno, ACT_STOP, twi->phase == PHASE_IDLE ? 1U : bit);
    } else if (v & TWSTA) {
        begin(uno, ACT_START, bit);
    } else if (twi->phase == PHASE_STARTED) {
        begin(uno, ACT_ADDRESS, BYTE_BITS * bit);
    } else if (twi->phase == PHASE_ADDRESSED) {
        begin(uno, twi->reading ? ACT_RECEIVE : ACT_SEND, BYTE_BITS * bit);
    }
}

static void twsr_write(avr_t *avr, avr_io_addr_t addr, uint8_t v, void *param)
{
    (void)param;
    avr->data[addr] = (uint8_t)((avr->data[addr] & 0xF8U) | (v & 3U));
}

/* At RETI a flag that the handler did not clear asks again. */
static void handler_left(avr_irq_t *irq, uint32_t running, void *param)
{
    uno_t *uno = param;
    avr_t *avr = uno->avr;

    (void)irq;
    if (!running && (avr->data[TWCR_ADDR] & TWINT) && (avr->data[TWCR_ADDR] & TWIE)) {
        avr_raise_interrupt(avr, &uno->twi.simavr->twi);
    }
}

void twi_init(uno_t *uno)
{
    uno->twi.simavr                   = (avr_twi_t *)core_find_io(uno->avr, "twi", 0);
    uno->twi.simavr->twi.raise_sticky = 1;
    core_hook(uno, TWCR_ADDR, NULL, twcr_write);
    core_hook(uno, TWSR_ADDR, NULL, twsr_write);
    core_hook(uno, TWDR_ADDR, NULL, NULL);
    core_hook(uno, TWBR_ADDR, NULL, NULL);
    avr_irq_register_notify(uno->twi.simavr->twi.irq + AVR_INT_IRQ_RUNNING, handler_left, uno);
}

void twi_after_reset(uno_t *uno)
{
    uno->twi.action           = ACT_NONE;
    uno->twi.phase            = PHASE_IDLE;
    uno->twi.selected         = NULL;
    uno->avr->data[TWSR_ADDR] = S_NOTHING;
    uno->avr->data[TWDR_ADDR] = 0xFF;
}

/* --- a file of registers as a device --- */

static bool registers_start(void *ctx, bool reading)
{
    twi_registers_t *file = ctx;

    if (!reading) { file->pointer_set = false; }
    return true;
}

static bool registers_write(void *ctx, uint8_t byte)
{
    twi_registers_t *file = ctx;

    if (file->pointer_set) {
        file->regs[file->pointer++] = byte;
    } else {
        file->pointer     = byte;
        file->pointer_set = true;
    }
    return true;
}

static uint8_t registers_read(void *ctx)
{
    twi_registers_t *file = ctx;

    return file->regs[file->pointer++];
}

void uno_twi_attach_registers(uno_t *uno, uint8_t address)
{
    twi_t *twi = &uno->twi;

    if (twi->device_count == TWI_DEVICES) { return; }
    twi->devices[twi->device_count++] = (twi_device_t){.ctx     = &twi->registers,
                                                       .address = address,
                                                       .start   = registers_start,
                                                       .write   = registers_write,
                                                       .read    = registers_read};
}

void uno_twi_registers_get(const uno_t *uno, uint8_t *regs)
{
    memcpy(regs, uno->twi.registers.regs, sizeof uno->twi.registers.regs);
}

void uno_twi_registers_set(uno_t *uno, const uint8_t *regs)
{
    memcpy(uno->twi.registers.regs, regs, sizeof uno->twi.registers.regs);
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "uno_internal.h"

#include <string.h>

enum {
    TWBR_ADDR = 0xB8,
    TWSR_ADDR = 0xB9,
    TWDR_ADDR = 0xBB,
    TWCR_ADDR = 0xBC,

    PINC_ADDR  = 0x26,
    DDRC_ADDR  = 0x27,
    PORTC_ADDR = 0x28,
    SDA_MASK   = 0x10,
    SCL_MASK   = 0x20,

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
    S_LOST       = 0x38, /* arbitration */
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
        if (device->address == sla_rw >> 1 && !twi->fault.deaf &&
            device->start(device->ctx, twi->reading)) {
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
    const bool acked = twi->selected && !twi->fault.deaf &&
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
    if (twi->fault.sda_stuck) { uno->avr->data[TWDR_ADDR] = 0; }
    uno->stats.twi_bytes++;
    status(uno, (cr & TWEA) ? S_GOT_ACKED : S_GOT_NACKED, true);
}

/* A line held low keeps the bus as it is: no START and no STOP without SDA, nothing without SCL. */
static bool is_held(const twi_t *twi)
{
    if (twi->fault.scl_stuck) { return true; }
    return twi->fault.sda_stuck && (twi->action == ACT_START || twi->action == ACT_STOP);
}

/* A one that is sent while somebody holds SDA low is another master's zero. */
static bool loses_arbitration(uno_t *uno)
{
    twi_t *twi = &uno->twi;

    if (!twi->fault.sda_stuck || (twi->action != ACT_ADDRESS && twi->action != ACT_SEND) ||
        uno->avr->data[TWDR_ADDR] == 0U) {
        return false;
    }
    twi->action   = ACT_NONE;
    twi->phase    = PHASE_IDLE;
    twi->selected = NULL;
    status(uno, S_LOST, true);
    return true;
}

static avr_cycle_count_t action_done(avr_t *avr, avr_cycle_count_t when, void *param)
{
    uno_t        *uno    = param;
    twi_t        *twi    = &uno->twi;
    const uint8_t action = twi->action;

    if (is_held(twi)) { return when + bit_cycles(avr); }
    if (loses_arbitration(uno)) { return 0; }
    twi->action = ACT_NONE;
    switch (action) {
    case ACT_STOP:
        avr->data[TWCR_ADDR] &= (uint8_t)~TWSTO;
        twi->phase    = PHASE_IDLE;
        twi->selected = NULL;
        status(uno, S_NOTHING, false);
        if (twi->restart || avr->data[TWCR_ADDR] & TWSTA) {
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

/* --- the lines as port C --- */

static uint8_t pinc_read(avr_t *avr, avr_io_addr_t addr, void *param)
{
    const uno_t       *uno    = param;
    const twi_fault_t *fault  = &uno->twi.fault;
    const uint8_t      output = avr->data[DDRC_ADDR];
    const uint8_t      lines  = (uint8_t)((fault->sda_stuck ? 0 : SDA_MASK) |
                                    (fault->scl_stuck ? 0 : SCL_MASK));
    const uint8_t      inputs = (uint8_t)((avr->data[addr] & ~(SDA_MASK | SCL_MASK)) | lines);

    return (uint8_t)((inputs & ~output) | (avr->data[PORTC_ADDR] & output));
}

/* The program pulls SCL low by making it an output that is low. */
static void scl_follows(uno_t *uno, uint8_t output, uint8_t port)
{
    twi_t     *twi = &uno->twi;
    const bool scl = !(output & ~port & SCL_MASK) && !twi->fault.scl_stuck;

    if (scl == twi->scl) { return; }
    twi->scl = scl;
    if (!scl || uno->avr->data[TWCR_ADDR] & TWEN) { return; }
    uno->stats.twi_free_clocks++;
    if (twi->fault.sda_clocks && --twi->fault.sda_clocks == 0U) { twi->fault.sda_stuck = 0; }
}

static void ddrc_written(avr_irq_t *irq, uint32_t value, void *param)
{
    uno_t *uno = param;

    (void)irq;
    scl_follows(uno, (uint8_t)value, uno->avr->data[PORTC_ADDR]);
}

static void portc_written(avr_irq_t *irq, uint32_t value, void *param)
{
    uno_t *uno = param;

    (void)irq;
    scl_follows(uno, uno->avr->data[DDRC_ADDR], (uint8_t)value);
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

    avr_irq_t *port_c = ((avr_ioport_t *)core_find_io(uno->avr, "port", 'C'))->io.irq;
    avr_irq_register_notify(port_c + IOPORT_IRQ_DIRECTION_ALL, ddrc_written, uno);
    avr_irq_register_notify(port_c + IOPORT_IRQ_REG_PORT, portc_written, uno);
    uno->avr->io[AVR_DATA_TO_IO(PINC_ADDR)].r.c     = pinc_read;
    uno->avr->io[AVR_DATA_TO_IO(PINC_ADDR)].r.param = uno;
    uno->twi.scl                                    = true;
}

void twi_after_reset(uno_t *uno)
{
    uno->twi.action           = ACT_NONE;
    uno->twi.phase            = PHASE_IDLE;
    uno->twi.selected         = NULL;
    uno->twi.scl              = !uno->twi.fault.scl_stuck;
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

bool twi_attach(uno_t *uno, const twi_device_t *device)
{
    twi_t *twi = &uno->twi;

    if (twi->device_count == TWI_DEVICES) { return false; }
    twi->devices[twi->device_count++] = *device;
    return true;
}

void uno_twi_attach_registers(uno_t *uno, uint8_t address)
{
    const twi_device_t device = {.ctx     = &uno->twi.registers,
                                 .address = address,
                                 .start   = registers_start,
                                 .write   = registers_write,
                                 .read    = registers_read};

    (void)twi_attach(uno, &device);
}

void uno_twi_set_fault(uno_t *uno, const twi_fault_t *fault)
{
    uno->twi.fault = *fault;
}

void uno_twi_get_fault(const uno_t *uno, twi_fault_t *fault)
{
    *fault = uno->twi.fault;
}

void uno_twi_registers_get(const uno_t *uno, uint8_t *regs)
{
    memcpy(regs, uno->twi.registers.regs, sizeof uno->twi.registers.regs);
}

void uno_twi_registers_set(uno_t *uno, const uint8_t *regs)
{
    memcpy(uno->twi.registers.regs, regs, sizeof uno->twi.registers.regs);
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "uno_internal.h"

#include <string.h>

enum {
    EECR_ADDR  = 0x3F,
    EEDR_ADDR  = 0x40,
    EEARL_ADDR = 0x41,
    EEARH_ADDR = 0x42,

    EEPM  = 0x30, /* EECR */
    EERIE = 0x08,
    EEMPE = 0x04,
    EEPE  = 0x02,
    EERE  = 0x01,

    MODE_ERASE = 0x10,
    MODE_WRITE = 0x20,

    WINDOW_CYCLES     = 4,
    READ_HALT_CYCLES  = 4, /* "the CPU is halted for four cycles", section 8.6.3 */
    WRITE_HALT_CYCLES = 2,
    BOTH_CYCLES       = 54400, /* 3.4 ms, table 8-1 */
    HALF_CYCLES       = 28800, /* 1.8 ms */
};

static uint16_t address(const uno_t *uno)
{
    const avr_t *avr = uno->avr;

    return (uint16_t)((avr->data[EEARL_ADDR] | (avr->data[EEARH_ADDR] << 8)) %
                      uno->eeprom.simavr->size);
}

/* The ready interrupt is a level: EERIE while no write is under way. */
static void refresh(uno_t *uno)
{
    avr_int_vector_t *ready  = &uno->eeprom.simavr->ready;
    const bool        wanted = (uno->avr->data[EECR_ADDR] & EERIE) && !uno->eeprom.busy;

    if (wanted && !ready->pending) {
        avr_raise_interrupt(uno->avr, ready);
    } else if (!wanted && ready->pending) {
        avr_clear_interrupt(uno->avr, ready);
    }
}

static avr_cycle_count_t window_closed(avr_t *avr, avr_cycle_count_t when, void *param)
{
    (void)when;
    (void)param;
    avr->data[EECR_ADDR] &= (uint8_t)~EEMPE;
    return 0;
}

static void finish(uno_t *uno)
{
    eeprom_t *eeprom = &uno->eeprom;

    eeprom->simavr->eeprom[eeprom->addr] = eeprom->value;
    eeprom->busy                         = false;
    uno->avr->data[EECR_ADDR] &= (uint8_t)~EEPE;
}

static avr_cycle_count_t write_done(avr_t *avr, avr_cycle_count_t when, void *param)
{
    (void)avr;
    (void)when;
    finish(param);
    refresh(param);
    return 0;
}

static void begin_write(uno_t *uno, uint8_t mode)
{
    avr_t        *avr    = uno->avr;
    eeprom_t     *eeprom = &uno->eeprom;
    const uint8_t data   = avr->data[EEDR_ADDR];

    eeprom->addr  = address(uno);
    uint8_t *cell = &eeprom->simavr->eeprom[eeprom->addr];
    eeprom->value = mode == MODE_ERASE ? 0xFF : mode == MODE_WRITE ? *cell & data : data;
    if (mode != MODE_WRITE) { *cell = 0xFF; } /* erased first: what a power loss leaves */
    eeprom->busy = true;
    uno->stats.eeprom_writes++;
    avr_cycle_timer_register(avr, mode ? HALF_CYCLES : BOTH_CYCLES, write_done, uno);
    avr->cycle += WRITE_HALT_CYCLES;
}

static void eecr_write(avr_t *avr, avr_io_addr_t addr, uint8_t v, void *param)
{
    uno_t        *uno  = param;
    const uint8_t old  = avr->data[addr];
    const uint8_t ones = core_ones_written(avr, v);
    uint8_t       now  = (uint8_t)((v & (EERIE | EEMPE)) | (old & EEPE));

    now |= uno->eeprom.busy ? (old & EEPM) : (v & EEPM);
    if (ones & EEPE) {
        if (!uno->eeprom.busy && (old & EEMPE)) {
            begin_write(uno, v & EEPM);
            now = (uint8_t)((now | EEPE) & ~EEMPE);
        } else {
            uno->stats.eeprom_ignored++;
        }
    } else if ((v & EEMPE) && !(old & EEMPE)) {
        avr_cycle_timer_register(avr, WINDOW_CYCLES, window_closed, uno);
    }
    if ((v & EERE) && !uno->eeprom.busy) {
        avr->data[EEDR_ADDR] = uno->eeprom.simavr->eeprom[address(uno)];
        avr->cycle += READ_HALT_CYCLES;
    }
    avr->data[addr] = now;
    refresh(uno);
}

static void handler_left(avr_irq_t *irq, uint32_t running, void *param)
{
    (void)irq;
    if (!running) { refresh(param); }
}

void eeprom_init(uno_t *uno)
{
    uno->eeprom.simavr = (avr_eeprom_t *)core_find_io(uno->avr, "eeprom", 0);
    core_hook(uno, EECR_ADDR, NULL, eecr_write);
    avr_irq_register_notify(uno->eeprom.simavr->ready.irq + AVR_INT_IRQ_RUNNING, handler_left, uno);
}

void eeprom_before_reset(uno_t *uno, bool power_lost)
{
    if (uno->eeprom.busy && !power_lost) { finish(uno); }
    uno->eeprom.busy = false;
}

void eeprom_after_reset(uno_t *uno)
{
    uno->avr->data[EECR_ADDR] = 0;
}

void uno_eeprom_get(const uno_t *uno, uint32_t addr, uint8_t *bytes, uint32_t n)
{
    memcpy(bytes, uno->eeprom.simavr->eeprom + addr, n);
}

void uno_eeprom_set(uno_t *uno, uint32_t addr, const uint8_t *bytes, uint32_t n)
{
    memcpy(uno->eeprom.simavr->eeprom + addr, bytes, n);
}

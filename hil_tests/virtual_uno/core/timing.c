/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "uno_internal.h"

#include <simavr/avr_extint.h>

enum {
    TIFR0_ADDR  = 0x35,
    TIFR2_ADDR  = 0x37,
    PCIFR_ADDR  = 0x3B,
    EIFR_ADDR   = 0x3C,
    EIMSK_ADDR  = 0x3D,
    PCICR_ADDR  = 0x68,
    TIMSK0_ADDR = 0x6E,
    TIMSK2_ADDR = 0x70,
};

static void flags_write(avr_t *avr, avr_io_addr_t addr, uint8_t v, void *param)
{
    (void)param;
    v = core_ones_written(avr, v);
    for (uint8_t i = 0; i < avr->interrupts.vector_count; i++) {
        avr_int_vector_t *vector = avr->interrupts.vector[i];

        if (vector->raised.reg == addr && ((v >> vector->raised.bit) & vector->raised.mask)) {
            avr_clear_interrupt(avr, vector);
        }
    }
}

static void mask_write(avr_t *avr, avr_io_addr_t addr, uint8_t v, void *param)
{
    (void)param;
    avr->data[addr] = v;
    for (uint8_t i = 0; i < avr->interrupts.vector_count; i++) {
        avr_int_vector_t *vector = avr->interrupts.vector[i];

        if (vector->enable.reg != addr || vector->pending || !vector->raised.reg) { continue; }
        if (avr_regbit_get(avr, vector->enable) && avr_regbit_get(avr, vector->raised)) {
            avr_raise_interrupt(avr, vector);
        }
    }
}

static void vector_running(avr_irq_t *irq, uint32_t value, void *param)
{
    uno_t *uno = param;
    avr_t *avr = uno->avr;

    (void)irq;
    if (!value) { return; } /* RETI: its cost is in the instruction */

    uint64_t cost = TIMING_ENTRY_CYCLES;
    if (uno->timing.asleep) { cost += TIMING_WAKE_CYCLES; }
    uno->timing.asleep = false;
    uno->stats.interrupts++;
    probe_interrupt(uno, (uint8_t)(avr->pc / avr->vector_size), cost);
    avr->cycle += cost;
    /* the next burst of instructions was measured up to a timer that is now nearer */
    avr->run_cycle_count = avr->run_cycle_count > cost ? avr->run_cycle_count - cost : 1U;
}

static void for_each_vector(uno_t *uno, bool attach)
{
    for (uint8_t v = 1; v < UNO_VECTORS; v++) {
        avr_irq_t *irq = avr_get_interrupt_irq(uno->avr, v);

        if (!irq) { continue; }
        if (attach) {
            avr_irq_register_notify(irq + AVR_INT_IRQ_RUNNING, vector_running, uno);
        } else {
            avr_irq_unregister_notify(irq + AVR_INT_IRQ_RUNNING, vector_running, uno);
        }
    }
}

void timing_init(uno_t *uno)
{
    for_each_vector(uno, true);
    for (uint16_t addr = TIFR0_ADDR; addr <= TIFR2_ADDR; addr++) {
        core_hook(uno, addr, NULL, flags_write);
    }
    core_hook(uno, EIFR_ADDR, NULL, flags_write);
    core_hook(uno, PCIFR_ADDR, NULL, flags_write);
    for (uint16_t addr = TIMSK0_ADDR; addr <= TIMSK2_ADDR; addr++) {
        core_hook(uno, addr, NULL, mask_write);
    }
    core_hook(uno, EIMSK_ADDR, NULL, mask_write);
    core_hook(uno, PCICR_ADDR, NULL, mask_write);
}

void timing_free(uno_t *uno)
{
    for_each_vector(uno, false);
}

void timing_after_reset(uno_t *uno)
{
    uno->timing.asleep = false;
    avr_extint_set_strict_lvl_trig(uno->avr, 0, 0);
    avr_extint_set_strict_lvl_trig(uno->avr, 1, 0);
}

void timing_after_service(uno_t *uno)
{
    avr_t *avr = uno->avr;

    uno->timing.asleep = false;
    /* simavr counts -2, -1, 0 after SEI: two instructions; the chip lets one through */
    if (avr->interrupt_state == -1) {
        avr->interrupt_state = avr_has_pending_interrupts(avr) ? 1 : 0;
    }
}

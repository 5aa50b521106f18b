/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "uno_internal.h"

enum { PINB_ADDR = 0x23, PIND_ADDR = 0x29, PORTD_ADDR = 0x2B, PORT_STRIDE = 3 };

static void put(uno_t *uno, uint8_t bit, uint8_t level)
{
    pins_t       *pins = &uno->pins;
    const uint8_t mask = (uint8_t)(1U << bit);

    pins->port_d->external.pull_mask |= mask;
    if (level) {
        pins->port_d->external.pull_value |= mask;
        pins->level |= mask;
    } else {
        pins->port_d->external.pull_value &= (uint8_t)~mask;
        pins->level &= (uint8_t)~mask;
    }
}

/* Before simavr takes over a new PORT value: what floats follows its pull-up. */
static void port_written(avr_irq_t *irq, uint32_t value, void *param)
{
    uno_t *uno = param;

    (void)irq;
    for (uint8_t bit = 0; uno->pins.floating >> bit; bit++) {
        if (uno->pins.floating & (1U << bit)) { put(uno, bit, (value >> bit) & 1U); }
    }
}

/* simavr's own also tells listeners of every read; there are none, and polling loops are many. */
static uint8_t pin_read(avr_t *avr, avr_io_addr_t addr, void *param)
{
    const uint8_t output = avr->data[addr + 1U]; /* DDRx, and PORTx behind it */

    (void)param;
    return (uint8_t)((avr->data[addr] & ~output) | (avr->data[addr + 2U] & output));
}

static void pin_write(avr_t *avr, avr_io_addr_t addr, uint8_t v, void *param)
{
    const pins_t *pins = &((uno_t *)param)->pins;
    const uint8_t port = (uint8_t)((addr - PINB_ADDR) / PORT_STRIDE);

    v = core_ones_written(avr, v);
    pins->toggle[port](avr, addr, v, pins->toggle_param[port]);
}

void pins_init(uno_t *uno)
{
    pins_t *pins = &uno->pins;

    pins->port_d = (avr_ioport_t *)core_find_io(uno->avr, "port", 'D');
    pins->irq_d  = pins->port_d->io.irq;
    avr_irq_register_notify(pins->irq_d + IOPORT_IRQ_REG_PORT, port_written, uno);
    for (uint8_t i = 0; i < PINS_PORTS; i++) {
        const avr_io_addr_t io = (avr_io_addr_t)AVR_DATA_TO_IO(PINB_ADDR + PORT_STRIDE * i);

        pins->toggle[i]          = uno->avr->io[io].w.c;
        pins->toggle_param[i]    = uno->avr->io[io].w.param;
        uno->avr->io[io].w.c     = pin_write;
        uno->avr->io[io].w.param = uno;
        uno->avr->io[io].r.c     = pin_read;
        uno->avr->io[io].r.param = uno;
    }
}

void pins_drive(uno_t *uno, uint8_t bit, uint8_t level)
{
    const uint8_t mask = (uint8_t)(1U << bit);

    uno->pins.driven |= mask;
    uno->pins.floating &= (uint8_t)~mask;
    put(uno, bit, level);
    avr_raise_irq(uno->pins.irq_d + bit, level);
}

void pins_float(uno_t *uno, uint8_t bit)
{
    const uint8_t mask  = (uint8_t)(1U << bit);
    const uint8_t level = (uno->avr->data[PORTD_ADDR] >> bit) & 1U;

    uno->pins.driven &= (uint8_t)~mask;
    uno->pins.floating |= mask;
    put(uno, bit, level); /* without a pull-up an open CMOS input tends to read low */
    avr_raise_irq(uno->pins.irq_d + bit, level);
}

/* simavr clears PIND at reset but remembers the pins' last levels, and would then swallow
 * the next change; the outside world does not change by a reset, so PIND is put right. */
void pins_after_reset(uno_t *uno)
{
    const pins_t *pins = &uno->pins;

    for (uint8_t bit = 0; bit < 8U; bit++) {
        const uint8_t mask = (uint8_t)(1U << bit);
        uint8_t       high = (pins->driven & pins->level & mask) ? 1U : 0U;

        pins->irq_d[bit].value = high;
        if (high) { uno->avr->data[PIND_ADDR] |= mask; }
        if (pins->floating & mask) { put(uno, bit, 0); }
    }
    pins->irq_d[IOPORT_IRQ_PIN_ALL].value  = 0;
    pins->irq_d[IOPORT_IRQ_REG_PORT].value = 0;
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "uno_internal.h"

#include <stdlib.h>

enum {
    UCSRA_ADDR = 0xC0,
    UCSRB_ADDR = 0xC1,
    UCSRC_ADDR = 0xC2,
    UBRRL_ADDR = 0xC4,
    UBRRH_ADDR = 0xC5,
    UDR_ADDR   = 0xC6,

    RXC  = 0x80, /* UCSR0A */
    TXC  = 0x40,
    UDRE = 0x20,
    FE   = 0x10,
    DOR  = 0x08,
    U2X  = 0x02,

    RXCIE = 0x80, /* UCSR0B */
    TXCIE = 0x40,
    UDRIE = 0x20,
    RXEN  = 0x10,
    TXEN  = 0x08,
};

/* --- the wire --- */

static double device_bit_cycles(const avr_t *avr)
{
    const uint32_t ubrr = ((avr->data[UBRRH_ADDR] & 0x0FU) << 8) | avr->data[UBRRL_ADDR];

    return (double)((ubrr + 1U) * ((avr->data[UCSRA_ADDR] & U2X) ? 8U : 16U));
}

static uint64_t device_byte_cycles(const avr_t *avr)
{
    return (uint64_t)(USART_FRAME_BITS * device_bit_cycles(avr));
}

static double host_bit_cycles(const usart_t *usart)
{
    return UNO_CLOCK_HZ / usart->host_baud;
}

static void wire_to_vcd(uno_t *uno, uint8_t signal, uint8_t byte, uint64_t start, double bit)
{
    if (!uno->vcd.on) { return; }
    for (int32_t i = 0; i < USART_FRAME_BITS; i++) {
        vcd_put(&uno->vcd, signal, start + (uint64_t)(i * bit),
                usart_wire_level(byte, bit, (i + 0.5) * bit));
    }
}

/* --- flags and interrupts --- */

/* RXC and UDRE are levels: the interrupt is asked for as long as flag and enable are set. */
static void level_interrupt(avr_t *avr, avr_int_vector_t *vector, bool wanted)
{
    if (wanted && !vector->pending) {
        avr_raise_interrupt(avr, vector);
    } else if (!wanted && vector->pending) {
        avr_clear_interrupt(avr, vector);
    }
}

static void refresh(uno_t *uno)
{
    avr_t         *avr   = uno->avr;
    const usart_t *usart = &uno->usart;
    const uint8_t  b     = avr->data[UCSRB_ADDR];
    uint8_t        a     = avr->data[UCSRA_ADDR] & (TXC | 0x07U);

    if (usart->rx_count) { a |= RXC | usart->rx_error[0]; }
    if (usart->rx_lost) { a |= DOR; }
    if (!usart->tx_buffer_full) { a |= UDRE; }
    level_interrupt(avr, &usart->simavr->rxc, (a & RXC) && (b & RXCIE));
    level_interrupt(avr, &usart->simavr->udrc, (a & UDRE) && (b & UDRIE) && (b & TXEN));
    avr->data[UCSRA_ADDR] = a;
}

/* At RETI a level that still holds asks again. */
static void handler_left(avr_irq_t *irq, uint32_t running, void *param)
{
    (void)irq;
    if (!running) { refresh(param); }
}

/* --- transmitter --- */

static void tx_start(uno_t *uno, uint8_t byte, uint64_t at)
{
    uno->usart.tx_shift    = byte;
    uno->usart.tx_shifting = true;
    wire_to_vcd(uno, VCD_TX, byte, at, device_bit_cycles(uno->avr));
}

static avr_cycle_count_t tx_done(avr_t *avr, avr_cycle_count_t when, void *param)
{
    uno_t   *uno   = param;
    usart_t *usart = &uno->usart;
    uint8_t  bytes[USART_RESAMPLED_MAX], errors[USART_RESAMPLED_MAX];

    const uint32_t n = usart_wire_resample(usart->tx_shift, device_bit_cycles(avr),
                                           host_bit_cycles(usart), bytes, errors);
    for (uint32_t i = 0; i < n; i++) {
        usart_queue_put(&usart->to_host, bytes[i], when, true);
        if (errors[i]) { uno->stats.tx_framing_errors++; }
    }
    uno->stats.tx_bytes++;
    if (usart->tx_buffer_full) {
        usart->tx_buffer_full = false;
        tx_start(uno, usart->tx_buffer, when);
        refresh(uno);
        return when + device_byte_cycles(avr);
    }
    usart->tx_shifting = false;
    avr->data[UCSRA_ADDR] |= TXC;
    if (avr->data[UCSRB_ADDR] & TXCIE) { avr_raise_interrupt(avr, &usart->simavr->txc); }
    return 0;
}

static void udr_write(avr_t *avr, avr_io_addr_t addr, uint8_t v, void *param)
{
    uno_t   *uno   = param;
    usart_t *usart = &uno->usart;

    (void)addr;
    if (!(avr->data[UCSRB_ADDR] & TXEN)) { return; }
    if (usart->tx_buffer_full) {
        uno->stats.tx_overwrites++; /* "data will be ignored", section 20.6.1 */
        return;
    }
    if (usart->tx_shifting) {
        usart->tx_buffer      = v;
        usart->tx_buffer_full = true;
    } else {
        tx_start(uno, v, avr->cycle);
        avr_cycle_timer_register(avr, device_byte_cycles(avr), tx_done, uno);
    }
    refresh(uno);
}

/* --- receiver --- */

static uint8_t udr_read(avr_t *avr, avr_io_addr_t addr, void *param)
{
    uno_t        *uno   = param;
    usart_t      *usart = &uno->usart;
    const uint8_t byte  = usart->rx_data[0];

    (void)avr;
    (void)addr;
    if (usart->rx_count) {
        usart->rx_count--;
        usart->rx_data[0]  = usart->rx_data[1];
        usart->rx_error[0] = usart->rx_error[1];
    }
    if (usart->rx_shift_full && usart->rx_count < 2) {
        usart->rx_data[usart->rx_count]  = usart->rx_shift;
        usart->rx_error[usart->rx_count] = usart->rx_shift_error;
        usart->rx_count++;
        usart->rx_shift_full = false;
    }
    usart->rx_lost = false;
    refresh(uno);
    return byte;
}

static void rx_put(uno_t *uno, uint8_t byte, uint8_t error)
{
    usart_t *usart = &uno->usart;

    uno->stats.rx_bytes++;
    if (error) { uno->stats.rx_framing_errors++; }
    if (usart->rx_count < 2) {
        usart->rx_data[usart->rx_count]  = byte;
        usart->rx_error[usart->rx_count] = error;
        usart->rx_count++;
        return;
    }
    if (usart->rx_shift_full) { /* its start bit came when all three were full */
        usart->rx_lost = true;
        uno->stats.rx_overruns++;
    }
    usart->rx_shift       = byte;
    usart->rx_shift_error = error;
    usart->rx_shift_full  = true;
}

static avr_cycle_count_t rx_done(avr_t *avr, avr_cycle_count_t when, void *param)
{
    uno_t         *uno   = param;
    usart_t       *usart = &uno->usart;
    usart_queue_t *queue = &usart->to_device;
    const uint8_t  byte  = queue->bytes[queue->tail++];
    const double   bit   = host_bit_cycles(usart);

    if (avr->data[UCSRB_ADDR] & RXEN) {
        uint8_t        bytes[USART_RESAMPLED_MAX], errors[USART_RESAMPLED_MAX];
        const uint32_t n = usart_wire_resample(byte, bit, device_bit_cycles(avr), bytes, errors);

        for (uint32_t i = 0; i < n; i++) { rx_put(uno, bytes[i], errors[i]); }
        refresh(uno);
    }
    usart_queue_rewind(queue);
    if (queue->tail == queue->head) {
        usart->line_busy = false;
        return 0;
    }
    wire_to_vcd(uno, VCD_RX, queue->bytes[queue->tail], when, bit);
    return when + (uint64_t)(USART_FRAME_BITS * bit);
}

static void line_start(uno_t *uno)
{
    usart_t       *usart = &uno->usart;
    usart_queue_t *queue = &usart->to_device;
    const double   bit   = host_bit_cycles(usart);

    usart->line_busy = queue->tail != queue->head;
    if (!usart->line_busy) { return; }
    wire_to_vcd(uno, VCD_RX, queue->bytes[queue->tail], uno->avr->cycle, bit);
    avr_cycle_timer_register(uno->avr, (uint64_t)(USART_FRAME_BITS * bit), rx_done, uno);
}

/* --- control registers --- */

static void ucsra_write(avr_t *avr, avr_io_addr_t addr, uint8_t v, void *param)
{
    uno_t  *uno = param;
    uint8_t a   = avr->data[addr];

    if (v & TXC) {
        avr_clear_interrupt(avr, &uno->usart.simavr->txc);
        a &= (uint8_t)~TXC;
    }
    avr->data[addr] = (uint8_t)((a & ~0x03U) | (v & 0x03U));
    refresh(uno);
}

static void ucsrb_write(avr_t *avr, avr_io_addr_t addr, uint8_t v, void *param)
{
    uno_t *uno = param;

    avr->data[addr] = v;
    if (!(v & RXEN)) { /* "will flush the receive buffer", section 20.7.5 */
        uno->usart.rx_count      = 0;
        uno->usart.rx_shift_full = false;
        uno->usart.rx_lost       = false;
    }
    if ((v & TXCIE) && (avr->data[UCSRA_ADDR] & TXC)) {
        avr_raise_interrupt(avr, &uno->usart.simavr->txc);
    }
    refresh(uno);
}

void usart_init(uno_t *uno)
{
    usart_t *usart = &uno->usart;

    usart->simavr                    = (avr_uart_t *)core_find_io(uno->avr, "uart", 0);
    usart->simavr->rxc.raise_sticky  = 1;
    usart->simavr->udrc.raise_sticky = 1;
    usart->host_baud                 = 115200.0;
    core_hook(uno, UDR_ADDR, udr_read, udr_write);
    core_hook(uno, UCSRA_ADDR, NULL, ucsra_write);
    core_hook(uno, UCSRB_ADDR, NULL, ucsrb_write);
    core_hook(uno, UCSRC_ADDR, NULL, NULL);
    core_hook(uno, UBRRL_ADDR, NULL, NULL);
    core_hook(uno, UBRRH_ADDR, NULL, NULL);
    avr_irq_register_notify(usart->simavr->rxc.irq + AVR_INT_IRQ_RUNNING, handler_left, uno);
    avr_irq_register_notify(usart->simavr->udrc.irq + AVR_INT_IRQ_RUNNING, handler_left, uno);
}

void usart_free(usart_t *usart)
{
    free(usart->to_device.bytes);
    free(usart->to_host.bytes);
    free(usart->to_host.cycles);
}

void usart_after_reset(uno_t *uno)
{
    usart_t *usart = &uno->usart;

    usart->tx_buffer_full = usart->tx_shifting = false;
    usart->rx_count                            = 0;
    usart->rx_shift_full = usart->rx_lost = false;
    uno->avr->data[UCSRA_ADDR]            = UDRE;
    uno->avr->data[UCSRC_ADDR]            = 0x06; /* 8N1 */
    line_start(uno); /* what the host had still to send goes on being sent */
}

void uno_uart_host_baud(uno_t *uno, double baud)
{
    uno->usart.host_baud = baud;
}

void uno_uart_write(uno_t *uno, const uint8_t *bytes, uint32_t n)
{
    usart_queue_compact(&uno->usart.to_device);
    for (uint32_t i = 0; i < n; i++) { usart_queue_put(&uno->usart.to_device, bytes[i], 0, false); }
    if (!uno->usart.line_busy) { line_start(uno); }
}

uint32_t uno_uart_backlog(const uno_t *uno)
{
    return uno->usart.to_device.head - uno->usart.to_device.tail;
}

uint32_t uno_uart_available(const uno_t *uno)
{
    return uno->usart.to_host.head - uno->usart.to_host.tail;
}

uint32_t uno_uart_read(uno_t *uno, uint8_t *bytes, uint64_t *cycles, uint32_t n)
{
    usart_queue_t *queue = &uno->usart.to_host;
    uint32_t       given = 0;

    while (given < n && queue->tail != queue->head) {
        cycles[given] = queue->cycles[queue->tail];
        bytes[given]  = queue->bytes[queue->tail++];
        given++;
    }
    usart_queue_rewind(queue);
    return given;
}

void uno_uart_discard(uno_t *uno)
{
    uno->usart.to_host.tail = uno->usart.to_host.head = 0;
}

void uno_uart_cancel(uno_t *uno)
{
    usart_queue_t *queue = &uno->usart.to_device;

    /* the byte on the wire, if any, still arrives */
    if (queue->head > queue->tail) { queue->head = queue->tail + (uno->usart.line_busy ? 1U : 0U); }
}

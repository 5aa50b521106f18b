/* SPDX-License-Identifier: MIT */
#include "uart.h"

#include "idle.h"
#include "uno_pins.h"

#include <avr/interrupt.h>
#include <avr/io.h>

/* U2X: UBRR = clock / (8 * baud) - 1, rounded */
#define UBRR_FOR(baud) ((uint8_t)((F_CPU + 4UL * (baud)) / (8UL * (baud)) - 1UL))

uint8_t                 uart_tx_ring[UART_TX_LEN];
static volatile uint8_t tx_head; /* main loop writes: next free place */
static volatile uint8_t tx_tail; /* interrupt writes: next byte to send */

static volatile uint8_t  rx_ring[UART_RX_LEN]; /* interrupt writes, main loop reads */
static volatile uint8_t  rx_head;              /* interrupt writes */
static volatile uint8_t  rx_tail;              /* main loop writes */
static volatile uint16_t rx_overruns;          /* interrupt writes, main loop reads locked */

_Static_assert(UART_TX_LEN == 256, "tx indices wrap as uint8");
_Static_assert((UART_RX_LEN & (UART_RX_LEN - 1)) == 0, "rx indices wrap by a mask");

ISR(USART_UDRE_vect)
{
    idle_interrupted();
    const uint8_t tail = tx_tail;

    UDR0               = uart_tx_ring[tail];
    const uint8_t next = (uint8_t)(tail + 1U);
    tx_tail            = next;
    if (next == tx_head) { UCSR0B &= (uint8_t)~_BV(UDRIE0); }
}

ISR(USART_RX_vect)
{
    idle_interrupted();
    const uint8_t status = UCSR0A; /* before UDR0: reading that moves the receiver's FIFO on */
    const uint8_t byte   = UDR0;
    const uint8_t head   = rx_head;
    const uint8_t next   = (uint8_t)(head + 1U) & (UART_RX_LEN - 1U);

    uint8_t lost = (status & _BV(DOR0)) != 0U ? 1U : 0U; /* bytes after this one */

    if ((status & _BV(FE0)) != 0U || next == rx_tail) {
        ++lost;
    } else {
        rx_ring[head] = byte;
        rx_head       = next;
    }
    for (; lost != 0U; --lost) {
        const uint16_t count = rx_overruns;
        if (count != UINT16_MAX) { rx_overruns = count + 1U; }
    }
    idle_post_work();
}

void uart_init(uart_baud_t baud)
{
    UBRR0 = UBRR_FOR(115200);
    if (baud == UART_500000) { UBRR0 = UBRR_FOR(500000); }
    if (baud == UART_1000000) { UBRR0 = UBRR_FOR(1000000); }
    UCSR0A = _BV(U2X0);
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00); /* 8N1 */
    UCSR0B = _BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0);
}

bool uart_read(uint8_t *byte)
{
    const uint8_t tail = rx_tail;

    if (tail == rx_head) { return false; }
    *byte   = rx_ring[tail];
    rx_tail = (uint8_t)(tail + 1U) & (UART_RX_LEN - 1U);
    return true;
}

uint8_t uart_write_room(void)
{
    return (uint8_t)(tx_tail - tx_head - 1);
}

uint8_t uart_begin(void)
{
    return tx_head;
}

__attribute__((noinline)) void uart_end(uint8_t behind)
{
    __asm__ volatile("" ::: "memory"); /* the bytes stand before the interrupt is told of them */
    tx_head = behind;
    /* Not atomic and need not be: the interrupt only ever clears this bit, and it is wanted set. */
    UCSR0B |= _BV(UDRIE0);
}

void uart_put(uint8_t byte)
{
    uint8_t head = tx_head;

    if (uart_write_room() == 0U) { return; }
    uart_tx_ring[head++] = byte;
    uart_end(head);
}

uint16_t uart_rx_overruns(void)
{
    const uint8_t sreg = SREG;

    cli();
    const uint16_t count = rx_overruns;
    SREG                 = sreg;
    return count;
}

/* SPDX-License-Identifier: MIT */
/* runner_main - lets a host feed the shared modules on the chip and read what they answer.
 *
 * Linked from the firmware's own objects of shared_c and port, so that golden vectors judge the
 * very machine code that ships. Requests and replies over the polled USART, 2 Mbaud 8N1:
 *
 *   request  op u8 | length u8 | payload        reply  length u8 | payload
 *
 * All numbers little-endian. An unknown op is answered with length 0. One chip does not hold all
 * modules: runner.c serves most of them, and in an image of their own, runner_scale.c its two.
 */
#include "runner.h"

#include <avr/io.h>

static uint8_t buffer[RUNNER_REQUEST_MAX]; /* request payload, then the reply's in its place */

static uint8_t usart_read(void)
{
    while ((UCSR0A & (1U << RXC0)) == 0U) {}
    return UDR0;
}

static void usart_write(uint8_t byte)
{
    while ((UCSR0A & (1U << UDRE0)) == 0U) {}
    UDR0 = byte;
}

int main(void)
{
    UCSR0A = 1U << U2X0; /* UBRR 0: 16 MHz / 8 = 2 Mbaud */
    UCSR0B = (1U << RXEN0) | (1U << TXEN0);
    for (;;) {
        const uint8_t op  = usart_read();
        const uint8_t len = usart_read();
        for (uint8_t i = 0; i < len; i++) { buffer[i] = usart_read(); } /* len <= the most */
        const uint8_t reply_len = runner_serve(op, buffer, len);
        usart_write(reply_len);
        for (uint8_t i = 0; i < reply_len; i++) { usart_write(buffer[i]); }
    }
}

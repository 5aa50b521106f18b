/* SPDX-License-Identifier: MIT */
/* uart - USART0 as two byte rings served by interrupts, 115200 baud, 8N1.
 *
 * Model     UBRR 16 with U2X gives 117647 baud, 2.1 % high, as every Uno's (ATmega328P datasheet,
 *           table 20-6)
 * Sending   all or nothing: a block that does not fit is refused whole, so that no frame is torn
 * Bad data  bytes lost in the USART (data overrun), lost because the ring is full, or received
 *           with a framing error are counted, the last ones kept out of the ring
 * Context   main loop.  Cost of the interrupts: firmware/budget.toml
 */
#ifndef UART_H
#define UART_H

#include <stdbool.h>
#include <stdint.h>

enum {
    UART_TX_LEN = 256, /* indices are uint8 and wrap by themselves; one place stays empty */
    UART_RX_LEN = 64   /* 5.5 ms of a saturated line */
};

void uart_init(void);

/* Take a received byte; false if there is none. */
bool uart_read(uint8_t *byte);

/* Bytes that uart_write would accept now. */
uint8_t uart_write_room(void);

/* Queue len bytes, or none: false if they do not fit. */
bool uart_write(const uint8_t bytes[], uint8_t len);

/* Bytes lost or broken on the way in since reset; stops at 65535. */
uint16_t uart_rx_overruns(void);

#endif

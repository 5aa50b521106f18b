/* SPDX-License-Identifier: MIT */
/* uno_pins - every pin, timer and interrupt of the Arduino Uno that is in use, with its owner.
 *
 * Model     ATmega328P at 16 MHz on an Arduino Uno R3; anything not listed here is free
 * Rule      a register belongs to the driver that owns its line; nobody else touches it
 *
 *   Uno pin   port   owner      use
 *   D0        PD0    uart       RXD, from the host
 *   D1        PD1    uart       TXD, to the host
 *   D2        PD2    hx711      DOUT, INT0 on its falling edge; pull-up on, so that an open cable
 *                               reads "not ready" instead of floating to "ready"
 *   D3        PD3    hx711      PD_SCK
 *   D4        PD4    mpu6050    INT, PCINT20 on its edges; pull-up on, so that a line that nobody
 *                               wired is quiet: samples are then paced by Timer1's compare A
 *   D13       PB5    led        the board's own LED
 *   A4        PC4    twi        SDA; pull-ups on, so that a bus without parts rests high
 *   A5        PC5    twi        SCL
 *
 *   timer     owner      use
 *   Timer1    ticks      free-running, 16 MHz / 8; overflow interrupt
 *             mpu6050    OCR1A and its interrupt's bit in TIMSK1: paces samples where INT does not
 *   watchdog  watchdog   0.5 s, system reset
 *
 *   register  owner      use
 *   GPIOR0    idle       flags between interrupts and the main loop, reachable by sbi and cbi;
 *             mpu6050    three of them
 *             twi        one
 *   GPIOR1    twi        bytes left of a transfer
 */
#ifndef UNO_PINS_H
#define UNO_PINS_H

#include <avr/io.h>

#ifndef F_CPU
#define F_CPU 16000000UL
#endif
_Static_assert(F_CPU == 16000000UL, "the drivers' timing is written for the Uno's 16 MHz");

/* hx711: both lines on port D, whose registers sbi, cbi and sbic reach in one instruction. */
#define HX711_PORT   PORTD
#define HX711_DDR    DDRD
#define HX711_PIN    PIND
#define HX711_DOUT   PD2
#define HX711_PD_SCK PD3
#define HX711_vect   INT0_vect

/* led */
#define LED_PORT PORTB
#define LED_DDR  DDRB
#define LED_BIT  PB5

/* twi */
#define TWI_PORT PORTC
#define TWI_DDR  DDRC
#define TWI_PIN  PINC
#define TWI_SDA  PC4
#define TWI_SCL  PC5

#define TWI_LEFT GPIOR1

/* mpu6050 */
#define IMU_PORT     PORTD
#define IMU_PIN      PIND
#define IMU_INT      PD4
#define IMU_PCINT    PCINT20
#define IMU_INT_vect PCINT2_vect

/* idle */
#define IDLE_FLAGS      GPIOR0
#define IDLE_WORK_BIT   0 /* an interrupt has work for the main loop */
#define IDLE_ASLEEP_BIT 1 /* the processor sleeps; the interrupt that wakes it notes the time */
#define IMU_ARMED_BIT   2 /* a burst lies ready on the bus, and the next interrupt begins it */
#define IMU_WAITS_BIT   3 /* data are ready, and no burst was */
#define IMU_LENT_BIT    4 /* a guest has the bus */
#define TWI_BUSY_BIT    5 /* a transfer is under way */

#endif

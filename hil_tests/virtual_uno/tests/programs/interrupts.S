; SPDX-License-Identifier: GPL-3.0-or-later
; Interrupt entry, and the one instruction after SEI and RETI.
; Toggling PB0 and PC0 as outputs raises PCINT0 and PCINT1 (datasheet section 13.1).
; Results, in SRAM from 0x100: [0] r16 when PCINT0 came, [1] r16 when PCINT1 came.
#define __SFR_OFFSET 0
#include <avr/io.h>

.global PCINT0_vect
PCINT0_vect:                ; entry 4 + jmp 3 + sts 2 + reti 4 = 13
    sts 0x0100, r16
    reti
.global PCINT1_vect
PCINT1_vect:
    sts 0x0101, r16
    reti
.global TIMER1_COMPA_vect
TIMER1_COMPA_vect:          ; entry 4 + jmp 3 + reti 4 = 11
    reti

.global interrupted
.type interrupted, @function
interrupted:                ; call 4 + sbi 2 + 1000 + cbi 2 + ret 4 = 1012
    sbi PORTD, 3
    .rept 1000
    nop
    .endr
    cbi PORTD, 3
    ret
.size interrupted, . - interrupted

.global main
main:
    clr r16
    sbi DDRB, 0
    sbi DDRC, 0
    sbi DDRD, 3
    ldi r24, 0x01
    sts PCMSK0, r24
    sts PCMSK1, r24
    ldi r24, 0x03
    sts PCICR, r24
    sbi PORTB, 0
    sbi PORTC, 0
    sei
    inc r16                 ; one instruction, then PCINT0: sees 1
    inc r16                 ; one instruction after its RETI, then PCINT1: sees 2
    inc r16
    inc r16
    ldi r24, hi8(300)       ; one compare match, 300 cycles on, in the midst of the nops
    sts OCR1AH, r24
    ldi r24, lo8(300)
    sts OCR1AL, r24
    ldi r24, 0x02
    sts TIMSK1, r24
    ldi r24, 0x01
    sts TCCR1B, r24
    call interrupted
    ldi r24, 0
    sts TCCR1B, r24
    sts TIMSK1, r24
1:  rjmp 1b

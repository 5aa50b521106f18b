; SPDX-License-Identifier: GPL-3.0-or-later
; Code whose cost is counted by hand from the instruction set manual (AVRe+, 16-bit PC).
; main calls each function once, then brackets a stretch with PD3 and stops in a loop.
#define __SFR_OFFSET 0
#include <avr/io.h>

.macro function name
.global \name
.type \name, @function
\name:
.endm
.macro endfunction name
.size \name, . - \name
.endm

function count_empty        ; call 4 + ret 4 = 8
    ret
endfunction count_empty

function count_loop         ; 8 + ldi 1 + 100 * (dec 1 + brne 2) - 1 = 308
    ldi r24, 100
1:  dec r24
    brne 1b
    ret
endfunction count_loop

function count_memory       ; 8 + lds 2 + sts 2 + push 2 + pop 2 + ld 2 + st 2 + lpm 3 = 23
    lds r24, 0x0100
    sts 0x0100, r24
    push r24
    pop r24
    ld r24, X
    st X, r24
    lpm r24, Z
    ret
endfunction count_memory

function count_arithmetic   ; 8 + mul 2 + fmuls 2 + adiw 2 + movw 1 + add 1 + in 1 + out 1 = 18
    mul r24, r25
    fmuls r20, r21
    adiw r24, 1
    movw r24, r22
    add r24, r25
    in r24, GPIOR0
    out GPIOR0, r24
    ret
endfunction count_arithmetic

function count_bits         ; 20, as below
    sbi GPIOR0, 0           ; 2
    cbi GPIOR0, 0           ; 2
    sbic GPIOR0, 0          ; bit clear: skips one word, 2
    nop
    clr r24                 ; 1
    sbrc r24, 0             ; bit clear: skips two words, 3
    sts 0x0100, r24
    sbrs r24, 0             ; bit clear: does not skip, 1
    nop                     ; 1
    ret                     ; 8 + 2 + 2 + 2 + 1 + 3 + 1 + 1 = 20
endfunction count_bits

function count_jumps        ; 8 + rjmp 2 + jmp 3 + ldi 2 + ijmp 2 = 17
    rjmp 1f
1:  jmp 2f
2:  ldi r30, pm_lo8(3f)
    ldi r31, pm_hi8(3f)
    ijmp
3:  ret
endfunction count_jumps

function count_near         ; reached by RCALL: 3 + 4 = 7
    ret
endfunction count_near

function count_nested       ; 8 + rcall 3 + ret 4 = 15
    rcall count_near
    ret
endfunction count_nested

function count_tail         ; call 4 + jmp 3 + ret 4 = 11; count_empty, by jump: 3 + 4 = 7
    jmp count_empty
endfunction count_tail

.global main
main:
    ldi r26, 0x00
    ldi r27, 0x01
    call count_empty
    call count_loop
    call count_memory
    call count_arithmetic
    call count_bits
    call count_jumps
    call count_nested
    call count_tail
    sbi DDRD, 3
    sbi PORTD, 3            ; the bracket: between the pin's edges lie
    .rept 37                ; 37 nop and the 2 cycles of cbi
    nop
    .endr
    cbi PORTD, 3
1:  rjmp 1b

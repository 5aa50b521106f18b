/* SPDX-License-Identifier: MIT */
/* port_mass - product and division of mass.c. Contract: shared_c/src/port_mass.h
 *
 *   uint32_t port_mass_scale(uint32_t counts_q7, uint32_t span_q16, uint32_t half)
 *                            r25:r22             r21:r18            r17:r14
 *
 * The product grows above the span, whose bytes are used up from below: after each of four rounds
 * all of it moves down by a byte. `half` is there from the start, and so ends at the bottom.
 * The division by 2^26 is three bytes and two bits, that by 125 goes byte by byte, as on paper: a
 * remainder below 125 and a byte make n < 32000, for which (n * 33555) >> 22 is n / 125, exactly.
 * The 38 bits to be divided begin with the upper six, which are below 125 themselves.
 * Time: constant.
 */

#define sum0    r14 /* the product's upper part; at first `half` */
#define sum1    r15
#define sum2    r16
#define sum3    r17
#define sum4    r26
#define span0   r18 /* the span's bytes left, then the product's lower part above them */
#define span1   r19
#define span2   r20
#define span3   r21
#define counts0 r22
#define counts1 r23
#define counts2 r24
#define counts3 r25
#define zero    r27
#define left    r30

#define reciprocal0 r22 /* 33555 */
#define reciprocal1 r23
#define divisor     r24 /* 125 */
#define remainder   r25
#define byte        r31
#define low         r20 /* of n * 33555: bytes 1, 2 and 3 */
#define digit0      r18
#define digit       r19

        .section .text.port_mass_scale, "ax", @progbits
        .global port_mass_scale
        .type   port_mass_scale, @function
port_mass_scale:
        push    sum0
        push    sum1
        push    sum2
        push    sum3
        clr     zero
        clr     sum4
        ldi     left, 4
1:      mul     counts0, span0
        add     sum0, r0
        adc     sum1, r1
        adc     sum2, zero
        adc     sum3, zero
        adc     sum4, zero
        mul     counts1, span0
        add     sum1, r0
        adc     sum2, r1
        adc     sum3, zero
        adc     sum4, zero
        mul     counts2, span0
        add     sum2, r0
        adc     sum3, r1
        adc     sum4, zero
        mul     counts3, span0
        add     sum3, r0
        adc     sum4, r1
        mov     span0, span1        /* down by a byte */
        mov     span1, span2
        mov     span2, span3
        mov     span3, sum0
        mov     sum0, sum1
        mov     sum1, sum2
        mov     sum2, sum3
        mov     sum3, sum4
        clr     sum4
        dec     left
        brne    1b

        ldi     left, 2
2:      lsr     sum3
        ror     sum2
        ror     sum1
        ror     sum0
        ror     span3
        dec     left
        brne    2b
        mov     remainder, sum3
        ldi     reciprocal0, lo8(33555)
        ldi     reciprocal1, hi8(33555)
        ldi     divisor, 125
        ldi     left, 4
3:      mov     byte, sum2          /* from the top; digits come in at the bottom */
        mov     sum2, sum1
        mov     sum1, sum0
        mov     sum0, span3
        mul     remainder, reciprocal1
        movw    digit0, r0
        mul     byte, reciprocal0
        mov     low, r1
        mul     byte, reciprocal1
        add     low, r0
        adc     digit0, r1
        adc     digit, zero
        mul     remainder, reciprocal0
        add     low, r0
        adc     digit0, r1
        adc     digit, zero
        lsl     digit0
        rol     digit
        lsl     digit0
        rol     digit
        mov     span3, digit
        mul     digit, divisor
        mov     remainder, byte
        sub     remainder, r0
        dec     left
        brne    3b

        clr     r1                  /* what C expects in r1 */
        mov     r22, span3
        mov     r23, sum0
        mov     r24, sum1
        mov     r25, sum2
        pop     sum3
        pop     sum2
        pop     sum1
        pop     sum0
        ret
        .size   port_mass_scale, . - port_mass_scale

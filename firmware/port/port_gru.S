/* SPDX-License-Identifier: MIT */
/* port_gru - some of the units of a recurrent network. Contract: shared_c/src/port_gru.h
 *
 *   void port_gru_units(int16_t next[], const int16_t seen[10], const port_gru_unit_t units[],
 *                       r25:r24         r23:r22                 r21:r20
 *                       uint8_t first)
 *                       r18
 *
 *   int16_t port_gru_score(const int16_t states[8], const int8_t weights[8], int16_t bias)
 *   r25:r24                r25:r24                  r23:r22                  r21:r20
 *   int16_t port_gru_log2_q8(uint16_t number)
 *   r25:r24                  r25:r24
 *
 * A unit's three sums grow side by side, so that what is seen is read once.
 * Time: units the same for all data but for a few cycles by signs; log2 6 cycles a leading zero.
 */

#define __SP_L__ 0x3d
#define __SP_H__ 0x3e
#define SPLIT  3 /* PORT_GRU_SPLIT */
#define UNITS  8
#define INPUTS 2

#define WEIGHT r18
#define LEFT   r19
#define SEEN_L r20
#define SEEN_H r21
/* The first of the sums is r25:r24. */
#define UPDATE   r8
#define UPDATE_1 r9
#define NEW      r12
#define NEW_1    r13
#define GIVEN    r14
#define GIVEN_1  r15
#define STREAM   r10
#define SEEN     r6
#define AT       r16 /* 2 bytes a unit */
#define zero     r17

/* Of the product with the low byte the upper one counts, rounded down. */
.macro add_product low, high, none=zero
        lpm     WEIGHT, Z+
        mulsu   WEIGHT, SEEN_L      /* leaves its sign in the carry */
        sbc     \high, \none
        add     \low, r1
        adc     \high, \none
        muls    WEIGHT, SEEN_H
        add     \low, r0
        adc     \high, r1
.endm

.macro begin low, high
        lpm     \low, Z+
        lpm     \high, Z+
.endm

/* r21:r20 = sigmoid at r25:r24, Q16.  A macro: three calls a unit would take 170 cycles a step. */
.macro sigmoid
        bst     r25, 7
        brtc    .Lpositive\@
        com     r25
        neg     r24
        sbci    r25, 0xFF
.Lpositive\@:
        cpi     r25, 32             /* beyond the table: as good as its end */
        brlo    .Lwithin\@
        ldi     r25, 31
        ldi     r24, 255
.Lwithin\@:
        lsl     r25
        ldi     r30, lo8(port_gru_sigmoid_q16)
        ldi     r31, hi8(port_gru_sigmoid_q16)
        add     r30, r25
        adc     r31, zero
        lpm     r20, Z+
        lpm     r21, Z+
        lpm     r22, Z+
        lpm     r23, Z+
        sub     r22, r20
        sbc     r23, r21
        mul     r23, r24
        add     r20, r0
        adc     r21, r1
        mul     r22, r24
        add     r20, r1
        adc     r21, zero
        brtc    .Ldone\@
        com     r21
        neg     r20
        sbci    r21, 0xFF
.Ldone\@:
.endm

/* r25:r24 = r23:r22, signed, times r21:r20 / 2^16, half up */
.macro share
        mulsu   r23, r21
        movw    r24, r0
        mul     r22, r20
        mov     r18, r1
        mulsu   r23, r20
        sbc     r25, zero
        add     r18, r0
        adc     r24, r1
        adc     r25, zero
        mul     r22, r21
        add     r18, r0
        adc     r24, r1
        adc     r25, zero
        lsl     r18
        adc     r24, zero
        adc     r25, zero
.endm

        .section .text.port_gru_units, "ax", @progbits
        .global port_gru_units
        .type   port_gru_units, @function
port_gru_units:
        ldi     r26, 0              /* 14 registers from r6 on; no frame */
        ldi     r27, 0
        ldi     r30, lo8(gs(1f))
        ldi     r31, hi8(gs(1f))
        jmp     __prologue_saves__ + 2 * (18 - 14)
1:      movw    r28, r24
        movw    SEEN, r22
        movw    STREAM, r20
        mov     AT, r18
        lsl     AT
        clr     zero
.Leach_unit:
        movw    r30, STREAM
        movw    r26, SEEN
        begin   r24, r25
        begin   UPDATE, UPDATE_1
        begin   NEW, NEW_1
        ldi     LEFT, INPUTS / 2
        rcall   add_products
        movw    GIVEN, NEW
        begin   NEW, NEW_1
        ldi     LEFT, UNITS / 2
        rcall   add_products
        movw    STREAM, r30

        asr     r25
        ror     r24
        sigmoid
        movw    r22, NEW
        share
        add     r24, GIVEN
        adc     r25, GIVEN_1
        sigmoid
        subi    r21, 0x80
        asr     r21
        ror     r20
        asr     r21
        ror     r20
        movw    GIVEN, r20          /* n */
        movw    r24, UPDATE
        asr     r25
        ror     r24
        sigmoid
        movw    r30, SEEN
        add     r30, AT
        adc     r31, zero
        ldd     r22, Z+2*INPUTS
        ldd     r23, Z+2*INPUTS+1
        sub     r22, GIVEN
        sbc     r23, GIVEN_1
        share
        add     r24, GIVEN
        adc     r25, GIVEN_1
        st      Y+, r24
        st      Y+, r25
        subi    AT, -2
        cpi     AT, 2 * SPLIT
        breq    1f
        cpi     AT, 2 * UNITS
        breq    1f
        rjmp    .Leach_unit
1:      in      r28, __SP_L__
        in      r29, __SP_H__
        clr     r1                  /* what the routine expects, and C */
        ldi     r30, 14
        jmp     __epilogue_restores__ + 2 * (18 - 14)
        .size   port_gru_units, . - port_gru_units

/* All three sums += weights at Z . what is seen at X, LEFT pairs of it. */
        .type   add_products, @function
add_products:
        .rept   2
        ld      SEEN_L, X+
        ld      SEEN_H, X+
        add_product r24, r25
        add_product UPDATE, UPDATE_1
        add_product NEW, NEW_1
        .endr
        dec     LEFT
        brne    add_products
        ret

        .section .text.port_gru_score, "ax", @progbits
        .global port_gru_score
        .type   port_gru_score, @function
port_gru_score:
        movw    r26, r24
        movw    r30, r22
        movw    r24, r20            /* the sum */
        ldi     r22, 0
        ldi     r23, UNITS
1:      ld      SEEN_L, X+
        ld      SEEN_H, X+
        add_product r24, r25, r22
        dec     r23
        brne    1b
        clr     r1
        ret
        .size   port_gru_score, . - port_gru_score

        .section .text.port_gru_log2_q8, "ax", @progbits
        .global port_gru_log2_q8
        .type   port_gru_log2_q8, @function
port_gru_log2_q8:
        ldi     r19, 16
1:      dec     r19
        lsl     r24
        rol     r25
        brcc    1b                  /* the leading one has left: r25 is the part */
        mov     r24, r25
        mov     r18, r25
        neg     r18
        mul     r25, r18            /* 0 where the part is */
        ldi     r18, 88
        mul     r1, r18
        add     r24, r1
        clr     r1
        adc     r19, r1
        mov     r25, r19
        ret
        .size   port_gru_log2_q8, . - port_gru_log2_q8

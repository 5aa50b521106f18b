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
 *   int16_t port_gru_octaves(uint16_t halves, uint16_t floor_q8)
 *   r25:r24                  r25:r24          r23:r22
 *
 * A unit's three sums grow side by side, of 24 bits, so that what is seen is read once.
 * Time: units the same for all data but for a few cycles by signs; octaves 6 cycles a leading zero.
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
/* Sums of three bytes: the low one, then those that count, which are r24, r25 of the first. */
#define RESET_0  r22
#define UPDATE_0 r8
#define UPDATE   r10
#define UPDATE_1 r11
#define NEW_0    r9
#define NEW      r12
#define NEW_1    r13
#define GIVEN    r14
#define GIVEN_1  r15
#define STREAM   r6
#define SEEN     r4
#define AT       r16 /* 2 bytes a unit */
#define zero     r17

.macro add_product low, mid, high, none=zero
        lpm     WEIGHT, Z+
        mulsu   WEIGHT, SEEN_L      /* leaves its sign in the carry */
        sbc     \high, \none
        add     \low, r0
        adc     \mid, r1
        adc     \high, \none
        muls    WEIGHT, SEEN_H
        add     \mid, r0
        adc     \high, r1
.endm

.macro begin low, mid, high
        mov     \low, r18           /* a half */
        lpm     \mid, Z+
        lpm     \high, Z+
.endm

        .section .text.port_gru_units, "ax", @progbits
        .global port_gru_units
        .type   port_gru_units, @function
port_gru_units:
        ldi     r26, 0              /* 16 registers from r4 on; no frame */
        ldi     r27, 0
        ldi     r30, lo8(gs(1f))
        ldi     r31, hi8(gs(1f))
        jmp     __prologue_saves__ + 2 * (18 - 16)
1:      movw    r28, r24
        movw    SEEN, r22
        movw    STREAM, r20
        mov     AT, r18
        lsl     AT
        clr     zero
.Leach_unit:
        movw    r30, STREAM
        movw    r26, SEEN
        ldi     r18, 0x80
        begin   RESET_0, r24, r25
        begin   UPDATE_0, UPDATE, UPDATE_1
        begin   NEW_0, NEW, NEW_1
        ldi     LEFT, INPUTS
        rcall   add_products
        movw    GIVEN, NEW
        ldi     r18, 0x80
        begin   NEW_0, NEW, NEW_1
        ldi     LEFT, UNITS
        rcall   add_products
        movw    STREAM, r30

        asr     r25
        ror     r24
        rcall   sigmoid
        movw    r22, NEW
        rcall   share
        add     r24, GIVEN
        adc     r25, GIVEN_1
        rcall   sigmoid
        subi    r21, 0x80
        asr     r21
        ror     r20
        asr     r21
        ror     r20
        movw    GIVEN, r20          /* n */
        movw    r24, UPDATE
        asr     r25
        ror     r24
        rcall   sigmoid
        movw    r30, SEEN
        add     r30, AT
        adc     r31, zero
        ldd     r22, Z+2*INPUTS
        ldd     r23, Z+2*INPUTS+1
        sub     r22, GIVEN
        sbc     r23, GIVEN_1
        rcall   share
        add     r24, GIVEN
        adc     r25, GIVEN_1
        st      Y+, r24
        st      Y+, r25
        subi    AT, -2
        cpi     AT, 2 * SPLIT
        breq    1f
        cpi     AT, 2 * UNITS
        brne    .Leach_unit
1:      in      r28, __SP_L__
        in      r29, __SP_H__
        clr     r1                  /* what the routine expects, and C */
        ldi     r30, 16
        jmp     __epilogue_restores__ + 2 * (18 - 16)
        .size   port_gru_units, . - port_gru_units

/* All three sums += weights at Z . what is seen at X, LEFT of it. */
        .type   add_products, @function
add_products:
        ld      SEEN_L, X+
        ld      SEEN_H, X+
        add_product RESET_0, r24, r25
        add_product UPDATE_0, UPDATE, UPDATE_1
        add_product NEW_0, NEW, NEW_1
        dec     LEFT
        brne    add_products
        ret

/* r21:r20 = sigmoid at r25:r24, Q16 */
        .type   sigmoid, @function
sigmoid:
        bst     r25, 7
        brtc    1f
        com     r25
        neg     r24
        sbci    r25, 0xFF
1:      cpi     r25, 32             /* beyond the table: as good as its end */
        brlo    2f
        ldi     r25, 31
        ldi     r24, 255
2:      lsl     r25
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
        brtc    3f
        com     r21
        neg     r20
        sbci    r21, 0xFF
3:      ret

/* r25:r24 = r23:r22, signed, times r21:r20 / 2^16, half up */
        .type   share, @function
share:
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
        ret

        .section .text.port_gru_score, "ax", @progbits
        .global port_gru_score
        .type   port_gru_score, @function
port_gru_score:
        movw    r26, r24
        movw    r30, r22
        movw    r24, r20            /* the sum: r19, r24, r25 */
        ldi     r19, 0
        ldi     r22, 0
        ldi     r23, UNITS
1:      ld      SEEN_L, X+
        ld      SEEN_H, X+
        add_product r19, r24, r25, r22
        dec     r23
        brne    1b
        clr     r1
        ret
        .size   port_gru_score, . - port_gru_score

        .section .text.port_gru_octaves, "ax", @progbits
        .global port_gru_octaves
        .type   port_gru_octaves, @function
port_gru_octaves:
        sbiw    r24, 0
        breq    4f
        ldi     r19, 16
1:      dec     r19
        lsl     r24
        rol     r25
        brcc    1b                  /* the leading one has left: r25 is the part */
        mov     r18, r25
        neg     r18
        mul     r25, r18            /* 0 where the part is */
        ldi     r18, 88
        mul     r1, r18
        add     r25, r1
        clr     r1
        adc     r19, r1
        sub     r25, r22
        sbc     r19, r23
        brcs    3f
        mov     r24, r25
        mov     r25, r19
        cpi     r25, 10
        brlo    2f
        ldi     r25, 10
        ldi     r24, 0
2:      lsl     r24
        rol     r25
        lsl     r24
        rol     r25
        ret
3:      ldi     r24, 0
        ldi     r25, 0
4:      ret
        .size   port_gru_octaves, . - port_gru_octaves

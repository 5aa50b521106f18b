/* SPDX-License-Identifier: MIT */
/* port_turn - one step of an attitude filter. Contract: shared_c/src/port_turn.h
 *
 *   uint8_t port_turn(mahony_step_t *step, const int16_t gyr[3], const int16_t acc[3],
 *                  r25:r24              r23:r22               r21:r20
 *                  const int32_t bias_q16[3])
 *                  r19:r18
 *
 * Products are 16 x 16 bits signed, of two pairs in r16..r23, where MULSU wants them; sums are 32
 * bits.  T tells which axis is averaged, and then which half of the quaternion is turned.
 * What waits or stays: r10..r13 pointers to gyr and bias, then loss and a; r8, r9 for the flags.
 * Time: the same for all data but for a few cycles by the axis and where a value is limited.
 */

/* Offsets in mahony_step_t; mahony.c asserts that they are these. */
#define QUAT_Q30    0
#define QUAT_Q14    16
#define CUT_Q22     24
#define EAST_Q14    28
#define NORTH_Q14   34
#define NORM_ERROR  40
#define RATE        42
#define RATE_RES    48
#define CORRECT     54
#define LEVEL_Q14   56
#define SAMPLE      60
#define FLAGS       61
#define TURN_RES    62
#define SQUARE_RES  68
#define LOSS_RES    70
#define SCALE_RES   72
#define GYRO_Q33    74
#define SQUARE      76
#define CUBIC       78
#define LOWPASS     80
#define CORRECT_Q18 82
#define MEAN        84 /* of axis 0; axis 1 lies 8 bytes behind */
#define MEAN_RES    88
#define CORRECT_RES 90
/* What lies beyond Y+63 is reached through Z, which points to here. */
#define FAR         NORM_ERROR

#define ACC_ZERO 0 /* bits of flags */
#define RAILED   1

#include "port_sums.inc"
#include "port_turn_parts.inc"

        .section .text.port_turn, "ax", @progbits
        .global port_turn
        .type   port_turn, @function
port_turn:
        .irp    n, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 15, 16, 17, 28, 29
        push    r\n
        .endr

        movw    r28, r24            /* Y = step */
        movw    r10, r22            /* gyr and bias_q16 wait here */
        movw    r12, r18
        movw    r30, r20            /* acc */
        clr     zero
        ld      r16, Z+
        ld      r17, Z+
        ld      r18, Z+
        ld      r19, Z+
        ld      r20, Z+
        ld      r21, Z+
        clr     r9                  /* values at a rail */
        rail    r9, r17
        rail    r9, r19
        rail    r9, r21
        ldd     r24, Y+SAMPLE
        inc     r24
        std     Y+SAMPLE, r24
        bst     r24, 0              /* T = axis */

        /* Level acceleration: SUM0 of this axis, SUM3 of the other one */
        movw    r30, r28
        adiw    r30, EAST_Q14
        brtc    1f
        adiw    r30, NORTH_Q14 - EAST_Q14
1:      call    port_dot_pairs
        copy    SUM0, SUM3
        brtc    2f
        sbiw    r30, 2 * (NORTH_Q14 - EAST_Q14)
2:      call    port_dot_pairs
        plus_at Y+LEVEL_Q14, SUM0   /* what waited, of the sample before */
        std     Y+LEVEL_Q14, r24
        std     Y+LEVEL_Q14+1, r25
        std     Y+LEVEL_Q14+2, r26
        std     Y+LEVEL_Q14+3, r27
        or      r16, r17
        or      r16, r18
        or      r16, r19
        or      r16, r20
        or      r16, r21
        mov     r8, r16             /* 0: no acceleration */
        brne    3f
        clr     r20                 /* correct_q19 */
        clr     r21
        rjmp    no_level
3:      movw    r30, r28
        adiw    r30, FAR
        ldd     r18, Z+LOWPASS-FAR
        ldd     r19, Z+LOWPASS-FAR+1
        ldd     r20, Z+CORRECT_Q18-FAR
        ldd     r21, Z+CORRECT_Q18-FAR+1
        brtc    4f
        adiw    r30, 8
4:
#define LEVEL_MEAN r24, r25, r22, r23
        ldd     r24, Z+MEAN-FAR
        ldd     r25, Z+MEAN-FAR+1
        ldd     r22, Z+MEAN-FAR+2
        ldd     r23, Z+MEAN-FAR+3
        minus   SUM0, LEVEL_MEAN
        minus   SUM0, LEVEL_MEAN
        carry   Z+MEAN_RES-FAR, SUM0
        movw    r16, r4
        accumulate r6, r7, LEVEL_MEAN, PAIR0, PAIR1, mul
        mov     r16, r23            /* inside -2^27..2^27-1, if its upper byte is in -8..7 */
        subi    r16, -8
        cpi     r16, 16
        brlo    5f
        ldi     r16, 0xF8           /* the nearer end: 0x07FFFFFF or 0xF8000000 */
        lsl     r23
        sbc     r22, r22
        com     r22
        mov     r24, r22
        mov     r25, r22
        mov     r23, r22
        eor     r23, r16
5:      std     Z+MEAN-FAR, r24
        std     Z+MEAN-FAR+1, r25
        std     Z+MEAN-FAR+2, r22
        std     Z+MEAN-FAR+3, r23
        /* turn = (mean >> 8) correct_q18, in r4:r3:r2:r0: upper 16 bits 2^8, then the lower 8 */
        product SUM0, PAIR3, PAIR2, mul
        mul     r25, r21
        add     r2, r0
        adc     r3, r1
        adc     r4, zero
        mul     r25, r20
        add     r2, r1
        adc     r3, zero
        adc     r4, zero
        ldd     r18, Z+CORRECT_RES-FAR
        ldd     r19, Z+CORRECT_RES-FAR+1
        brts    6f
        com     r0                  /* -turn - 1, and the carry is set */
        com     r2
        com     r3
        com     r4
6:      adc     r0, r18             /* axis 1: no carry came out of turn */
        adc     r2, r19
        adc     r3, zero
        adc     r4, zero
        std     Z+CORRECT_RES-FAR, r0
        std     Z+CORRECT_RES-FAR+1, r2
        mov     r20, r3
        mov     r21, r4
        mov     r16, r4             /* inside -512..511, if its upper byte is in -2..1 */
        subi    r16, -2
        cpi     r16, 4
        brlo    no_level
        ldi     r16, 0xFE
        lsl     r21
        sbc     r20, r20
        com     r20
        mov     r21, r20
        eor     r21, r16
no_level:
        std     Y+CORRECT, r20      /* and PAIR2 keeps it */
        std     Y+CORRECT+1, r21

        /* Rates, SUM0 = rate . rate <= 3 2^30, unsigned */
        movw    r26, r10            /* X = gyr */
        movw    r30, r12            /* Z = bias_q16 */
        adiw    r28, RATE
        clr     r2
        clr     r3
        movw    r4, r2
        ldi     r25, 3
each_rate:
        ld      r16, X+
        ld      r17, X+
        rail    r9, r17
        fetch   RATE_RES-RATE, r18, r19
        ld      r0, Z+
        sub     r18, r0
        ld      r0, Z+
        sbc     r19, r0
        std     Y+RATE_RES-RATE, r18
        std     Y+RATE_RES-RATE+1, r19
        ld      r0, Z+
        sbc     r16, r0
        ld      r0, Z+
        sbc     r17, r0
        brvc    1f
        lsl     r17                 /* it looks negative where it was too large */
        sbc     r16, r16
        ldi     r17, 0x80
        eor     r17, r16
1:      st      Y+, r16
        st      Y+, r17
        muls    r17, r17
        movw    r6, r0
        mul     r16, r16
        add     r2, r0
        adc     r3, r1
        adc     r4, r6
        adc     r5, r7
        fmulsu  r17, r16
        sbc     r5, zero
        add     r3, r0
        adc     r4, r1
        adc     r5, zero
        dec     r25
        brne    each_rate
        tst     r8
        brne    2f
        sbr     r25, 1 << ACC_ZERO
2:      cpse    r9, zero
        sbr     r25, 1 << RAILED
        std     Y+FLAGS-RATE_RES, r25 /* Y is behind the rates, until the turns come back */
        movw    r30, r28
        sbiw    r30, RATE_RES - FAR
        carry   Z+SQUARE_RES-FAR, SUM0

        /* loss, in PAIR1: r5:r4 times `square`, both unsigned */
        ldd     r6, Z+SQUARE-FAR
        ldd     r7, Z+SQUARE-FAR+1
        mul     r5, r7
        movw    r18, r0
        mul     r4, r6
        movw    r16, r0
        mul     r4, r7
        add     r17, r0
        adc     r18, r1
        adc     r19, zero
        mul     r5, r6
        add     r17, r0
        adc     r18, r1
        adc     r19, zero
        ldd     r6, Z+NORM_ERROR-FAR /* times 2^9: a byte and a bit */
        ldd     r7, Z+NORM_ERROR-FAR+1
        lsl     r6
        rol     r7
        sbc     r24, r24
        add     r17, r6
        adc     r18, r7
        adc     r19, r24
        carry   Z+LOSS_RES-FAR, PAIR0, PAIR1
        movw    r10, r18            /* it stays here */

        /* scale = gyro_q33 2^16 + carry - cubic loss */
        ldd     r16, Z+CUBIC-FAR
        ldd     r17, Z+CUBIC-FAR+1
        ldd     r2, Z+SCALE_RES-FAR
        ldd     r3, Z+SCALE_RES-FAR+1
        ldd     r22, Z+GYRO_Q33-FAR
        ldd     r23, Z+GYRO_Q33-FAR+1
        diminish r6, r7, r2, r3, PAIR3, PAIR1, PAIR0, mul
        std     Z+SCALE_RES-FAR, r2
        std     Z+SCALE_RES-FAR+1, r3

        /* Half angles c, b, a, each with the world's turn about the row of this sample */
        brtc    3f                  /* Z is behind north */
        sbiw    r30, NORTH_Q14 - EAST_Q14
3:      ldi     r16, 3
        mov     r8, r16
each_turn:
        ld      r17, -Y
        ld      r16, -Y
        fetch   TURN_RES-RATE, r2, r3
        ld      r19, -Z
        ld      r18, -Z
        product_onto SUM0, PAIR0, PAIR3
        accumulate r6, r7, SUM0, PAIR1, PAIR2
        std     Y+TURN_RES-RATE, r2
        std     Y+TURN_RES-RATE+1, r3
        movw    r26, r24
        movw    r24, r12
        movw    r12, r4
        dec     r8
        brne    each_turn
        sbiw    r28, RATE

/* The quaternion's product in twelve: w and x, then y and z as the same with other half angles.
 *   -dw = L (w + x) + b (y + z) + x (a - L) + z (c - b)
 *    dx = w (a + L) + y (b + c) - L (w + x) - b (y + z)
 * and -dy, dz with -b, c, L, -a in place of L, a, b, c. */
#define LOSS r10, r11
#define A r12, r13
#define B r24, r25
#define C r26, r27
        clt
        fetch   QUAT_Q14+2, PAIR1   /* x and z stay */
        fetch   QUAT_Q14+6, PAIR3
turn_half:
        fetch   QUAT_Q14+4, PAIR0
        movw    r20, r26
        plus16  PAIR2, B
        product SUM1, PAIR0, PAIR2
        plus16  PAIR0, PAIR3
        movw    r20, r24
        product SUM0, PAIR0, PAIR2
        fetch   QUAT_Q14, PAIR0
        movw    r20, r12
        plus16  PAIR2, LOSS
        accumulate r30, r31, SUM1, PAIR0, PAIR2
        plus16  PAIR0, PAIR1
        movw    r20, r10
        accumulate r30, r31, SUM0, PAIR0, PAIR2
        minus   SUM1, SUM0
        minus16 PAIR2, A
        diminish r30, r31, SUM0, PAIR1, PAIR2
        movw    r20, r26
        minus16 PAIR2, B
        accumulate r30, r31, SUM0, PAIR3, PAIR2
        movw    r30, r28
        brtc    4f
        adiw    r30, 8
4:      turn    sub, sbc, SUM0
        turn    adc, adc, SUM1      /* the bit shifted out is the one to add */
        brts    5f
        set
        movw    r20, r24
        movw    r24, r10
        negate  PAIR2
        movw    r10, r20
        movw    r20, r12
        movw    r12, r26
        negate  PAIR2
        movw    r26, r20
        rjmp    turn_half
5:
        shorten 0, PAIR0            /* from here on w x y z in PAIR0..3 */
        shorten 1, PAIR1
        shorten 2, PAIR2
        shorten 3, PAIR3

        square  SUM0, PAIR0
        square  SUM1, PAIR3
        copy    SUM2, SUM0
        plus24  SUM2, SUM1
        minus   SUM0, SUM1          /* ww - zz */
        square  SUM1, PAIR1
        plus24  SUM2, SUM1
        square  SUM3, PAIR2
        plus24  SUM2, SUM3          /* the norm's square; 2^28 is in byte 3 only */
        std     Y+NORM_ERROR, r11
        std     Y+NORM_ERROR+1, r12
        minus   SUM1, SUM3          /* xx - yy */
        copy    SUM2, SUM0
        plus    SUM2, SUM1
        row     EAST_Q14, SUM2
        minus   SUM0, SUM1
        row     NORTH_Q14+2, SUM0

        ldi     r24, 8
        product SUM0, PAIR1, PAIR2  /* xy */
        product SUM1, PAIR0, PAIR3  /* wz */
        copy    SUM2, SUM0
        minus   SUM2, SUM1
        row_from_half EAST_Q14+2, SUM2
        plus    SUM0, SUM1
        row_from_half NORTH_Q14, SUM0
        /* xz + wy = x (z - w) + w (x + y),  yz - wx = y (z + w) - w (x + y) */
        minus16 PAIR3, PAIR0
        product SUM0, PAIR1, PAIR3
        plus16  PAIR3, PAIR0
        plus16  PAIR3, PAIR0
        product SUM1, PAIR2, PAIR3
        plus16  PAIR1, PAIR2
        product SUM2, PAIR0, PAIR1
        plus    SUM0, SUM2
        row_from_half EAST_Q14+4, SUM0
        minus   SUM1, SUM2
        row_from_half NORTH_Q14+4, SUM1
        clr     r1                  /* what C expects in r1 */
        ldd     r24, Y+FLAGS

        .irp    n, 29, 28, 17, 16, 15, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2
        pop     r\n
        .endr
        ret
        .size   port_turn, . - port_turn

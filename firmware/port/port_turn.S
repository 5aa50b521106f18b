/* SPDX-License-Identifier: MIT */
/* port_turn - one step of an attitude filter. Contract: shared_c/src/port_turn.h
 *
 *   uint8_t port_turn(mahony_step_t *step, const int16_t gyr[3], const int16_t acc[3],
 *                  r25:r24              r23:r22               r21:r20
 *                  const int32_t bias_q16[3])
 *                  r19:r18
 *
 * Products are 16 x 16 bits signed, of two pairs in r16..r23, where MULSU wants them; MULSU leaves
 * the sign of its product in the carry, and SBC of zero extends it.  Sums are 32 bits.
 * Time: the same for all data but for rates that saturate and two cycles by the axis.
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
#define FAR         62 /* what lies from here on is reached through Z */
#define TURN_RES    (62 - FAR)
#define SQUARE_RES  (68 - FAR)
#define LOSS_RES    (70 - FAR)
#define SCALE_RES   (72 - FAR)
#define GYRO_Q33    (74 - FAR)
#define SQUARE      (76 - FAR)
#define CUBIC       (78 - FAR)
#define LOWPASS     (80 - FAR)
#define CORRECT_Q18 (82 - FAR)
#define MEAN        (84 - FAR) /* of axis 0; axis 1 lies 8 bytes behind */
#define MEAN_RES    (88 - FAR)
#define CORRECT_RES (90 - FAR)

#define ACC_ZERO 0 /* bits of flags */
#define RAILED   1

#define zero r26
#include "port_sums.inc"
#include "port_turn_parts.inc"

        .section .text.port_turn, "ax", @progbits
        .global port_turn
        .type   port_turn, @function
port_turn:
        .irp    n, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 28, 29
        push    r\n
        .endr

        movw    r28, r24            /* Y = step */
        movw    r10, r22            /* gyr and bias_q16 wait in SUM2 */
        movw    r12, r18
        movw    r30, r20            /* Z = acc */
        clr     zero
        ldi     r25, 0              /* flags */
        ld      r16, Z+
        ld      r17, Z+
        ld      r18, Z+
        ld      r19, Z+
        ld      r20, Z+
        ld      r21, Z+
        rail    r17
        rail    r19
        rail    r21
        mov     r24, r16
        or      r24, r17
        or      r24, r18
        or      r24, r19
        or      r24, r20
        or      r24, r21
        brne    1f
        sbr     r25, 1 << ACC_ZERO
1:
        std     Y+FLAGS, r25
        level   EAST_Q14, SUM0
        level   NORTH_Q14, SUM1
        movw    r30, r28
        adiw    r30, FAR            /* Z = the far part, by axis */
        ldd     r24, Y+SAMPLE
        inc     r24
        std     Y+SAMPLE, r24
        ldd     r18, Z+LOWPASS
        ldd     r19, Z+LOWPASS+1
        ldd     r20, Z+CORRECT_Q18
        ldd     r21, Z+CORRECT_Q18+1
        sbrs    r24, 0
        rjmp    axis_0
        movw    r16, r2             /* axis 1: north is averaged, east waits */
        movw    r2, r6
        movw    r6, r16
        movw    r16, r4
        movw    r4, r8
        movw    r8, r16
        adiw    r30, 8
axis_0:
        ldd     r16, Y+LEVEL_Q14    /* what waited, of the sample before */
        ldd     r17, Y+LEVEL_Q14+1
        ldd     r22, Y+LEVEL_Q14+2
        ldd     r23, Y+LEVEL_Q14+3
        std     Y+LEVEL_Q14, r6
        std     Y+LEVEL_Q14+1, r7
        std     Y+LEVEL_Q14+2, r8
        std     Y+LEVEL_Q14+3, r9
        clr     r8
        clr     r9                  /* correct_q19, if there is no acceleration */
        sbrc    r25, ACC_ZERO
        rjmp    no_level
        add     r2, r16
        adc     r3, r17
        adc     r4, r22
        adc     r5, r23
        /* mean, in r17:r16:r15:r14; SUM0 = level - 2 mean + carry */
        ldd     r14, Z+MEAN
        ldd     r15, Z+MEAN+1
        ldd     r22, Z+MEAN+2
        ldd     r23, Z+MEAN+3
        minus   SUM0, r14, r15, r22, r23
        minus   SUM0, r14, r15, r22, r23
        add16   Z+MEAN_RES, Z+MEAN_RES+1, SUM0
        std     Z+MEAN_RES, r2
        std     Z+MEAN_RES+1, r3
        movw    r16, r4
        movw    r4, r22
        movw    r2, r14             /* SUM0 = mean */
        accumulate SUM0, PAIR0, PAIR1
        mov     r16, r5             /* inside -2^27..2^27-1, if its upper byte is in -8..7 */
        subi    r16, -8
        cpi     r16, 16
        brlo    mean_fits
        ldi     r16, 0xFF           /* the nearer end: 0x07FFFFFF or 0xF8000000 */
        ldi     r17, 0x07
        sbrc    r5, 7
        com     r16
        sbrc    r5, 7
        com     r17
        mov     r2, r16
        mov     r3, r16
        mov     r4, r16
        mov     r5, r17
mean_fits:
        std     Z+MEAN, r2
        std     Z+MEAN+1, r3
        std     Z+MEAN+2, r4
        std     Z+MEAN+3, r5
        /* turn = (mean >> 8) correct_q18, in r8:r7:r6:r0: upper 16 bits 2^8, then the lower 8 */
        movw    r16, r4
        mov     r22, r3
        product SUM1, PAIR0, PAIR2
        mul     r22, r21
        add     r6, r0
        adc     r7, r1
        adc     r8, zero
        mul     r22, r20
        add     r6, r1
        adc     r7, zero
        adc     r8, zero
        ldd     r2, Z+CORRECT_RES
        ldd     r3, Z+CORRECT_RES+1
        clr     r4
        clr     r5
        sbrc    r24, 0
        rjmp    turn_east
        minus   SUM0, r0, r6, r7, r8
        rjmp    turn_north
turn_east:
        plus    SUM0, r0, r6, r7, r8
turn_north:
        std     Z+CORRECT_RES, r2
        std     Z+CORRECT_RES+1, r3
        mov     r16, r5             /* inside -512..511, if its upper byte is in -2..1 */
        subi    r16, -2
        cpi     r16, 4
        brlo    turn_fits
        ldi     r16, 0xFF
        ldi     r17, 0x01
        sbrc    r5, 7
        com     r16
        sbrc    r5, 7
        com     r17
        movw    r4, r16
turn_fits:
        movw    r8, r4
no_level:
        std     Y+CORRECT, r8
        std     Y+CORRECT+1, r9

        movw    r26, r10            /* X = gyr */
        movw    r30, r12            /* Z = bias_q16 */
        rate    0, r3, PAIR0
        rate    1, r5, PAIR1
        rate    2, r7, PAIR2
        ldd     r25, Y+FLAGS
        rail    r3                  /* upper bytes of gyr */
        rail    r5
        rail    r7
        std     Y+FLAGS, r25
        movw    r30, r28
        adiw    r30, FAR            /* Z = the far part */
        clr     zero

        square  SUM0, PAIR0
        square  SUM1, PAIR1
        plus    SUM0, SUM1
        square  SUM1, PAIR2
        plus    SUM0, SUM1          /* rate . rate <= 3 2^30, unsigned */
        carry   SQUARE_RES, SUM0

        /* loss: r5:r4 times `square`, both unsigned */
        ldd     r22, Z+SQUARE
        ldd     r23, Z+SQUARE+1
        mul     r5, r23
        movw    r8, r0
        mul     r4, r22
        movw    r6, r0
        mul     r4, r23
        add     r7, r0
        adc     r8, r1
        adc     r9, zero
        mul     r5, r22
        add     r7, r0
        adc     r8, r1
        adc     r9, zero
        ldd     r22, Y+NORM_ERROR   /* times 2^9: a byte and a bit */
        ldd     r23, Y+NORM_ERROR+1
        lsl     r22
        rol     r23
        sbc     r24, r24
        add     r7, r22
        adc     r8, r23
        adc     r9, r24
        carry   LOSS_RES, SUM1
        movw    r24, r8             /* loss waits here */

        /* scale: gyro_q33 2^16 + carry - cubic loss.  Rate 2 makes room for `cubic` */
        movw    r22, r8
        movw    r12, r20
        ldd     r20, Z+CUBIC
        ldd     r21, Z+CUBIC+1
        product SUM1, PAIR2, PAIR3
        movw    r20, r12
        ldd     r2, Z+SCALE_RES
        ldd     r3, Z+SCALE_RES+1
        ldd     r4, Z+GYRO_Q33
        ldd     r5, Z+GYRO_Q33+1
        minus   SUM0, SUM1
        std     Z+SCALE_RES, r2
        std     Z+SCALE_RES+1, r3
        movw    r22, r4

        /* half angles, each with the world's turn about the row of this sample */
        product SUM0, PAIR0, PAIR3
        product SUM1, PAIR1, PAIR3
        product SUM2, PAIR2, PAIR3
        fetch   CORRECT, r22, r23
        ldd     r16, Y+SAMPLE
        sbrc    r16, 0
        rjmp    about_east
        vector  NORTH_Q14
        rjmp    about_north
about_east:
        vector  EAST_Q14
about_north:
        accumulate SUM0, PAIR0, PAIR3
        accumulate SUM1, PAIR1, PAIR3
        accumulate SUM2, PAIR2, PAIR3
        carry   TURN_RES, SUM0
        carry   TURN_RES+2, SUM1
        carry   TURN_RES+4, SUM2
        movw    r16, r4
        movw    r18, r8
        movw    r20, r12
        movw    r30, r24            /* loss, until SUM3 is used no more */

        /* Turn: half angles in PAIR0..2, one component of the quaternion after another in PAIR3.
         * SUM0 is the scalar's, with the sign changed. */
        fetch   QUAT_Q14, r22, r23
        product SUM1, PAIR0, PAIR3
        product SUM2, PAIR1, PAIR3
        product SUM3, PAIR2, PAIR3
        fetch   QUAT_Q14+2, r22, r23
        product SUM0, PAIR0, PAIR3
        diminish SUM2, PAIR2, PAIR3
        accumulate SUM3, PAIR1, PAIR3
        fetch   QUAT_Q14+4, r22, r23
        accumulate SUM0, PAIR1, PAIR3
        accumulate SUM1, PAIR2, PAIR3
        diminish SUM3, PAIR0, PAIR3
        fetch   QUAT_Q14+6, r22, r23
        accumulate SUM0, PAIR2, PAIR3
        diminish SUM1, PAIR1, PAIR3
        accumulate SUM2, PAIR0, PAIR3
        /* ... and less the loss of each */
        movw    r16, r30
        diminish SUM3, PAIR0, PAIR3
        fetch   QUAT_Q14, r18, r19
        accumulate SUM0, PAIR0, PAIR1
        fetch   QUAT_Q14+2, r20, r21
        diminish SUM1, PAIR0, PAIR2
        fetch   QUAT_Q14+4, r22, r23
        diminish SUM2, PAIR0, PAIR3

        subtract_half 0, r16, SUM0  /* from here on w x y z in PAIR0..3 */
        add_half 1, r18, SUM1
        add_half 2, r20, SUM2
        add_half 3, r22, SUM3

        square  SUM0, PAIR0
        square  SUM1, PAIR3
        copy    SUM2, SUM0
        plus    SUM2, SUM1
        minus   SUM0, SUM1          /* ww - zz */
        square  SUM1, PAIR1
        plus    SUM2, SUM1
        square  SUM3, PAIR2
        plus    SUM2, SUM3          /* the norm's square; 2^28 is in byte 3 only */
        std     Y+NORM_ERROR, r11
        std     Y+NORM_ERROR+1, r12
        minus   SUM1, SUM3          /* xx - yy */
        copy    SUM2, SUM0
        plus    SUM2, SUM1
        row     EAST_Q14, SUM2
        minus   SUM0, SUM1
        row     NORTH_Q14+2, SUM0

        product SUM0, PAIR1, PAIR2  /* xy */
        product SUM1, PAIR0, PAIR3  /* wz */
        copy    SUM2, SUM0
        minus   SUM2, SUM1
        row_from_half EAST_Q14+2, SUM2
        plus    SUM0, SUM1
        row_from_half NORTH_Q14, SUM0
        product SUM0, PAIR1, PAIR3  /* xz */
        accumulate SUM0, PAIR0, PAIR2
        row_from_half EAST_Q14+4, SUM0
        product SUM0, PAIR2, PAIR3  /* yz */
        diminish SUM0, PAIR0, PAIR1
        row_from_half NORTH_Q14+4, SUM0
        clr     r1                  /* what C expects in r1 */
        ldd     r24, Y+FLAGS

        .irp    n, 29, 28, 17, 16, 15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2
        pop     r\n
        .endr
        ret
        .size   port_turn, . - port_turn

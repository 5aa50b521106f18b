/* SPDX-License-Identifier: MIT */
/* port_watch - whether what a scale measures stands. Contract: shared_c/src/port_watch.h
 *
 *   bool port_watch(scale_t *scale, int32_t counts_q7, int32_t raw_q7, bool early)
 *   r24             r25:r24         r23:r20            r19:r16         r14
 *
 * Time: constant but for 14 cycles a bit of grain, 20 for eight of them.
 */

#define SCALE_BEGUN   6
#define SCALE_STEADY  7
#define SCALE_GRAIN   9
#define SCALE_BAND    10
#define SCALE_ANCHOR  11
#define SCALE_LOW     15
#define SCALE_HIGH    17
#define SCALE_RAW     19
#define SCALE_ROUGH   21
#define SCALE_LAG     23
#define LEAP_MAX      4095

#define early  r14
#define wide_l r16
#define wide_h r17
#define at_l   r18
#define at_h   r19
#define raw_l  r20
#define raw_h  r21
#define band   r22
#define part   r23 /* of the band */
#define rough_l r24 /* then the reach */
#define rough_h r25
        /* X: leap, then how far ahead, then low.  Z: what is allowed. */

        .macro negate low, high
        neg     \high
        neg     \low
        sbc     \high, r1
        .endm

        .section .text.port_watch, "ax", @progbits
        .global port_watch
        .type   port_watch, @function
port_watch:
        push    r16
        push    r17
        push    r28
        push    r29
        movw    r28, r24
        rcall   in_grains
        movw    r26, r20
        movw    r20, r16
        movw    r22, r18
        movw    at_l, r26
        clt
        rcall   in_grains

        ldd     r26, Y + SCALE_RAW
        ldd     r27, Y + SCALE_RAW + 1
        std     Y + SCALE_RAW, raw_l
        std     Y + SCALE_RAW + 1, raw_h
        sub     r26, raw_l
        sbc     r27, raw_h
        brpl    1f
        negate  r26, r27
1:      ldd     r30, Y + SCALE_ROUGH
        ldd     r31, Y + SCALE_ROUGH + 1
        movw    rough_l, r30
        ldi     part, 4
2:      lsr     rough_h
        ror     rough_l
        dec     part
        brne    2b
        movw    wide_l, rough_l     /* the most that a leap counts for */
        lsr     wide_h
        ror     wide_l
        add     wide_l, rough_l
        adc     wide_h, rough_h
        subi    wide_l, lo8(-4)
        sbci    wide_h, hi8(-4)
        brtc    3f
        ldi     r26, lo8(LEAP_MAX)
        ldi     r27, hi8(LEAP_MAX)
3:      cp      r26, wide_l
        cpc     r27, wide_h
        brlo    4f
        movw    r26, wide_l
4:      add     r30, r26
        adc     r31, r27
        sub     r30, rough_l
        sbc     r31, rough_h
        std     Y + SCALE_ROUGH, r30
        std     Y + SCALE_ROUGH + 1, r31

        ldd     band, Y + SCALE_BAND
        movw    wide_l, rough_l
        cp      wide_l, band
        cpc     wide_h, r1
        brsh    5f
        mov     wide_l, band
        clr     wide_h
5:      movw    r26, raw_l
        sub     r26, at_l
        sbc     r27, at_h
        bst     r27, 7
        brtc    6f
        negate  r26, r27
6:      cp      r26, wide_l
        cpc     r27, wide_h
        brlo    7f
        movw    r26, wide_l
7:      brtc    8f
        negate  r26, r27
8:      ldd     r30, Y + SCALE_LAG
        ldd     r31, Y + SCALE_LAG + 1
        add     r26, r30
        adc     r27, r31
        ldi     part, 3
9:      asr     r31
        ror     r30
        dec     part
        brne    9b
        sub     r26, r30
        sbc     r27, r31
        std     Y + SCALE_LAG, r26
        std     Y + SCALE_LAG + 1, r27
        sbrs    r27, 7
        rjmp    1f
        negate  r26, r27
1:      rcall   four_fold
        movw    r30, wide_l
        movw    wide_l, rough_l
        rcall   four_fold
        movw    rough_l, wide_l
        mov     part, band
        lsr     part
        mov     r0, part            /* half of the band */
        lsr     part
        neg     part
        add     part, band
        cp      rough_l, part
        cpc     rough_h, r1
        brsh    1f
        mov     rough_l, part
        clr     rough_h
1:      add     rough_l, band       /* the reach */
        adc     rough_h, r1

        cp      r30, r26            /* carry: it lags */
        cpc     r31, r27
        mov     r30, band
        ldi     r31, 0
        ldd     part, Y + SCALE_STEADY
        sbrs    part, 0
        rjmp    2f
        brcs    moves
        add     r30, r0
        adc     r31, r1
        rjmp    3f
2:      sbrs    early, 0
        brcs    moves
        sbrc    early, 0
        mov     r30, r0
3:      ldd     part, Y + SCALE_BEGUN
        sbrs    part, 0
        rjmp    moves
        ldd     r26, Y + SCALE_LOW
        ldd     r27, Y + SCALE_LOW + 1
        cp      at_l, r26
        cpc     at_h, r27
        brge    4f
        movw    r26, at_l
        std     Y + SCALE_LOW, at_l
        std     Y + SCALE_LOW + 1, at_h
4:      ldd     r22, Y + SCALE_HIGH
        ldd     r23, Y + SCALE_HIGH + 1
        cp      r22, at_l
        cpc     r23, at_h
        brge    5f
        movw    r22, at_l
        std     Y + SCALE_HIGH, at_l
        std     Y + SCALE_HIGH + 1, at_h
5:      add     r30, r26            /* what is allowed + low - high */
        adc     r31, r27
        sub     r30, r22
        sbc     r31, r23
        brlt    moves
        add     r26, rough_l        /* reach + low - raw */
        adc     r27, rough_h
        sub     r26, raw_l
        sbc     r27, raw_h
        brlt    moves
        add     rough_l, raw_l      /* reach + raw - high */
        adc     rough_h, raw_h
        sub     rough_l, r22
        sbc     rough_h, r23
        ldi     r24, 1
        brge    6f
moves:
        sub     raw_l, at_l
        sbc     raw_h, at_h
        std     Y + SCALE_RAW, raw_l
        std     Y + SCALE_RAW + 1, raw_h
        std     Y + SCALE_LOW, r1
        std     Y + SCALE_LOW + 1, r1
        std     Y + SCALE_HIGH, r1
        std     Y + SCALE_HIGH + 1, r1
        ldi     r24, 0
6:      pop     r29
        pop     r28
        pop     r17
        pop     r16
        ret

four_fold:
        lsl     wide_l
        rol     wide_h
        lsl     wide_l
        rol     wide_h
        ret

/* r21:r20 = (r23:r20 - anchor) in grains, limited to 12 bits: then T is set */
in_grains:
        ldd     r24, Y + SCALE_ANCHOR
        sub     r20, r24
        ldd     r24, Y + SCALE_ANCHOR + 1
        sbc     r21, r24
        ldd     r24, Y + SCALE_ANCHOR + 2
        sbc     r22, r24
        ldd     r24, Y + SCALE_ANCHOR + 3
        sbc     r23, r24
        ldd     r24, Y + SCALE_GRAIN
        rjmp    2f
1:      mov     r20, r21
        mov     r21, r22
        mov     r22, r23
        lsl     r23
        sbc     r23, r23
2:      subi    r24, 8
        brsh    1b
        subi    r24, lo8(-8)
        rjmp    4f
3:      asr     r23
        ror     r22
        ror     r21
        ror     r20
4:      subi    r24, 1
        brsh    3b
        mov     r24, r23
        lsl     r24
        sbc     r24, r24            /* the sign in all bits */
        eor     r23, r24
        eor     r22, r24
        eor     r21, r24
        eor     r20, r24
        or      r23, r22
        brne    5f
        cpi     r21, 8
        brlo    6f
5:      set
        ldi     r21, 7
        ldi     r20, 0xFF
6:      eor     r20, r24
        eor     r21, r24
        ret
        .size   port_watch, . - port_watch

/* SPDX-License-Identifier: MIT */
/* port_curve - the calibration's curve. Contract: shared_c/src/port_curve.h
 *
 *   int32_t port_curve(const scale_t *scale, int32_t counts_q7)
 *                      r25:r24               r23:r20
 *
 * Points are read from the last but one down, each with its highest byte first. The T flag says
 * that counts fall with mass, and behind the search that the mass goes down from its point.
 * Time: 35 cycles a point that is passed over.
 */

#define SCALE_FALLING 5
#define SCALE_SLOPE   91
#define CONFIG_POINTS 28
#define CONFIG_COUNTS 36
#define CONFIG_MASS   68

#define past0  r18
#define past1  r19
#define past2  r20
#define past3  r21
#define value0 r22 /* counts, then |past|, then the rise, then the mass */
#define value1 r23
#define value2 r24
#define value3 r25
#define at     r0
#define place  r26

        .section .text.port_curve, "ax", @progbits
        .global port_curve
        .type   port_curve, @function
port_curve:
        push    r28
        push    r29
        movw    r28, r24
        movw    value2, r22
        movw    value0, r20
        rcall   in_31_bits
        ld      r30, Y              /* the configuration */
        ldd     r31, Y + 1
        ldd     at, Z + CONFIG_POINTS
        dec     at
        mov     r20, at
        lsl     r20
        lsl     r20
        movw    r26, r30            /* the last point's counts */
        adiw    r26, CONFIG_COUNTS
        add     r26, r20
        adc     r27, r1
        ldd     r20, Y + SCALE_FALLING
        bst     r20, 0
1:      ld      past3, -X
        ld      past2, -X
        ld      past1, -X
        ld      past0, -X
        dec     at
        sub     past0, value0       /* point - counts */
        sbc     past1, value1
        sbc     past2, value2
        sbc     past3, value3
        brts    2f
        rcall   negate
2:      tst     past3
        brpl    3f                  /* reached */
        tst     at
        brne    1b
3:      bst     past3, 7
        brtc    4f
        rcall   negate
4:      movw    value0, past0
        movw    value2, past2
        mov     place, at
        lsl     place
        lsl     place
        movw    r30, r28
        subi    r30, lo8(-(SCALE_SLOPE))
        sbci    r31, hi8(-(SCALE_SLOPE))
        add     r30, place
        adc     r31, r1
        ld      r18, Z
        ldd     r19, Z + 1
        ldd     r20, Z + 2
        ldd     r21, Z + 3
        ld      r30, Y
        ldd     r31, Y + 1
        movw    r28, r30
        subi    r28, lo8(-(CONFIG_MASS))
        sbci    r29, hi8(-(CONFIG_MASS))
        add     r28, place
        adc     r29, r1
        call    port_wide_high
        cpi     value3, 0x60
        brlo    5f
        ldi     value3, 0x5F
        ldi     value2, 0xFF
        ldi     value1, 0xFF
        ldi     value0, 0xFF
5:      ld      past0, Y            /* the point's mass */
        ldd     past1, Y + 1
        ldd     past2, Y + 2
        ldd     past3, Y + 3
        pop     r29
        pop     r28
        brts    6f
        add     value0, past0
        adc     value1, past1
        adc     value2, past2
        adc     value3, past3
        rjmp    in_31_bits
6:      sub     past0, value0
        sbc     past1, value1
        sbc     past2, value2
        sbc     past3, value3
        movw    value0, past0
        movw    value2, past2

/* value into 31 bits: the upper two differ only beyond. */
in_31_bits:
        mov     r18, value3
        subi    r18, 0xC0
        brpl    7f
        lsl     value3
        sbc     value0, value0      /* 0xFF where it is negative ... */
        com     value0              /* ... and now where it is not */
        mov     value1, value0
        mov     value2, value0
        mov     value3, value0
        ldi     r18, 0xC0
        eor     value3, r18
7:      ret

/* past = -past */
negate:
        com     past3
        com     past2
        com     past1
        neg     past0
        sbci    past1, 0xFF
        sbci    past2, 0xFF
        sbci    past3, 0xFF
        ret
        .size   port_curve, . - port_curve

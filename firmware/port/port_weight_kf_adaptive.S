/* SPDX-License-Identifier: MIT */
/* port_weight_kf_adaptive - a step of the adaptive filter.
 * Contract, and the names used here: shared_c/src/port_weight_kf_adaptive.h
 *
 *   int32_t port_weight_kf_adaptive_step(weight_kf_adaptive_t *kf, int32_t counts,
 *                                        r25:r24                   r23:r20
 *                                        uint8_t margin_sigmas)
 *                                        r18
 *
 * K is a restoring division. Each turn doubles the remainder, which stays below 2^32, and takes S
 * off where it can; the borrow is the complement of the quotient's bit. A 1 that starts at the
 * quotient's bottom falls out at its top after 16 turns and ends the loop.
 * Time: 17 cycles a turn, whichever way it goes; the rest differs by about 40 cycles.
 */

/* weight_kf_adaptive_t and its config; port_weight_kf_adaptive_layout.c holds these. */
#define KF_CONFIG    0
#define KF_ESTIMATE  2
#define KF_VAR       6
#define KF_NOISE     10
#define KF_BEFORE    14
#define KF_FRACTION  22
#define CONFIG_Q     0
#define CONFIG_MIN   4
#define CONFIG_MAX   6

.macro  name4 name, r0, r1, r2, r3
\name\()0 = \r0
\name\()1 = \r1
\name\()2 = \r2
\name\()3 = \r3
.endm
        name4   x, 26, 27, 30, 31       /* the estimate */
        name4   jump, 10, 11, 12, 13    /* the least distance, then J */
        name4   w, 16, 17, 18, 19       /* what is worked on */
        name4   z, 23, 20, 21, 22       /* the measurement, until S is known */
        name4   s, 20, 21, 22, 23       /* S */
        name4   part, 26, 27, 30, 31    /* a product; then P or R, what K is taken of */
        name4   res, 22, 23, 24, 25     /* the result */
zero = 2
is_open = 3
left0 = 6     /* l */
left1 = 7
margin = 8
jump5_0 = 8   /* j */
jump5_1 = 9
sigma0 = 14   /* the noise; where it is not needed, another factor */
sigma1 = 15
a0 = 24       /* an argument; the quotient; K */
a1 = 25
        /* Y: kf    T: z lies below x */

.macro  ldd4 to, at
        .irp    byte, 0, 1, 2, 3
        ldd     \to\byte, Y+\at+\byte
        .endr
.endm
.macro  std4 at, from
        .irp    byte, 0, 1, 2, 3
        std     Y+\at+\byte, \from\byte
        .endr
.endm
.macro  add4 to, what, first=add
        \first  \to\()0, \what\()0
        adc     \to\()1, \what\()1
        adc     \to\()2, \what\()2
        adc     \to\()3, \what\()3
.endm
.macro  sub4 from, what, first=sub
        \first  \from\()0, \what\()0
        sbc     \from\()1, \what\()1
        sbc     \from\()2, \what\()2
        sbc     \from\()3, \what\()3
.endm
.macro  cp4 one, other
        cp      \one\()0, \other\()0
        cpc     \one\()1, \other\()1
        cpc     \one\()2, \other\()2
        cpc     \one\()3, \other\()3
.endm
.macro  lsl4 what
        lsl     \what\()0
        rol     \what\()1
        rol     \what\()2
        rol     \what\()3
.endm

.macro  lsr4 what
        lsr     \what\()3
        ror     \what\()2
        ror     \what\()1
        ror     \what\()0
.endm
.macro  movw4 to, from
        movw    \to\()0, \from\()0
        movw    \to\()2, \from\()2
.endm
/* upper:lower = one * other, 16 bits each; upper and lower may be one quantity's halves */
.macro  mul16 lower0, lower1, upper0, upper1, one0, one1, other0, other1
        mul     \one1, \other1
        movw    \upper0, r0
        mul     \one0, \other0
        movw    \lower0, r0
        mul     \one0, \other1
        add     \lower1, r0
        adc     \upper0, r1
        adc     \upper1, zero
        mul     \one1, \other0
        add     \lower1, r0
        adc     \upper0, r1
        adc     \upper1, zero
.endm

        .section .text.port_weight_kf_adaptive_step, "ax", @progbits

/* w = w - x on the side of z, and the least so far */
distance:
        sub4    w, x
        brtc    1f
        com     w3
        com     w2
        com     w1
        neg     w0
        sbci    w1, 0xFF
        sbci    w2, 0xFF
        sbci    w3, 0xFF
1:      cp4     w, jump
        brge    2f
        movw4   jump, w
2:      ret
/* part = sigma * a */
times_sigma:
        mul16   part0, part1, part2, part3, sigma0, sigma1, a0, a1
        ret

        .global port_weight_kf_adaptive_step
        .type   port_weight_kf_adaptive_step, @function
port_weight_kf_adaptive_step:
        .irp    reg, 2, 3, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 28, 29
        push    \reg
        .endr
        movw    r28, r24
        mov     margin, w2

        ldd4    x, KF_ESTIMATE
        clr     z0                  /* counts * 2^8, by naming the bytes anew; halved */
        asr     z3
        .irp    byte, 2, 1, 0
        ror     z\byte
        .endr
        clt
        cp4     z, x
        brge    1f
        set
1:      ldi     a0, 0xFF            /* no distance is more than 2^31 - 1 */
        ldi     a1, 0xFF
        movw    jump0, a0
        ldi     a1, 0x7F
        movw    jump2, a0
        ldd     w0, Y+KF_BEFORE+4
        ldd     w1, Y+KF_BEFORE+5
        ldd     w2, Y+KF_BEFORE+6
        ldd     w3, Y+KF_BEFORE+7
        rcall   distance
        ldd4    w, KF_BEFORE
        std     Y+KF_BEFORE+4, w0
        std     Y+KF_BEFORE+5, w1
        std     Y+KF_BEFORE+6, w2
        std     Y+KF_BEFORE+7, w3
        rcall   distance
        .irp    byte, 0, 1, 2, 3
        mov     w\byte, z\byte
        .endr
        std4    KF_BEFORE, w
        rcall   distance            /* w = |z - x| */
        clr     zero
        clr     is_open
        ldd     sigma0, Y+KF_NOISE+1
        ldd     sigma1, Y+KF_NOISE+2
        mul     sigma0, margin      /* the margin in Q8, and halved in Q7 */
        movw    part0, r0
        mul     sigma1, margin
        add     part1, r0
        adc     r1, zero
        lsr     r1
        ror     part1
        ror     part0
        sub     jump0, part0        /* the least, less the margin */
        sbc     jump1, part1
        sbc     jump2, r1
        sbc     jump3, zero
        brge    1f
        movw    jump0, zero         /* and what is not open */
        movw    jump2, zero
1:      sub4    w, jump             /* L */
        movw    left0, sigma0       /* l = min(L, 4 sigma) */
        lsl     left0
        rol     left1
        cp      left0, w0
        cpc     left1, w1
        cpc     zero, w2
        cpc     zero, w3
        brcs    1f
        movw    left0, w0
1:      movw    w0, jump0           /* j */
        movw    w2, jump2
        lsr4    w
        lsr4    w
        or      w2, w3
        breq    1f
        ldi     w0, 0xFF
        ldi     w1, 0xFF
1:      movw    jump5_0, w0

        ldd4    w, KF_VAR
        ldd     r30, Y+KF_CONFIG
        ldd     r31, Y+KF_CONFIG+1
        ldd     a0, Z+CONFIG_Q
        ldd     a1, Z+CONFIG_Q+1
        add     w0, a0              /* P */
        adc     w1, a1
        adc     w2, zero
        adc     w3, zero
        movw    a0, sigma0
        rcall   times_sigma         /* R */
        movw4   s, w
        add4    s, part
        movw    a0, jump5_0
        rcall   times_sigma         /* N */
        cp4     w, part
        brcc    1f                  /* N <= P: what K is taken of is P */
        inc     is_open
        movw    r0, part0           /* else R = S - P, and N goes over S, or S if it is less */
        movw    part0, s0
        sub     part0, w0
        sbc     part1, w1
        movw    w0, r0
        movw    r0, part2
        movw    part2, s2
        sbc     part2, w2
        sbc     part3, w3
        movw    w2, r0
        cp4     s, w
        brcc    2f
        movw4   w, s
        rjmp    2f
passed: nop                         /* S cannot be taken off */
        rjmp    next_bit
1:      movw4   part, w
2:
        ldi     a0, 1
        clr     a1
3:      lsl4    w
        cp4     w, s
        brcs    passed
        sub4    w, s                /* no borrow is left */
next_bit:
        rol     a0
        rol     a1
        brcc    3b
        com     a0                  /* K */
        com     a1
        movw4   s, part
        tst     is_open
        brne    1f
        add     part0, w2           /* P + (remainder >> 16) */
        adc     part1, w3
        adc     part2, zero
        adc     part3, zero
1:      movw    sigma0, part0       /* part = (K part + 2^15) >> 16 */
        movw    w2, part2
        rcall   times_sigma
        lsl     part1
        movw    w0, part2
        movw    sigma0, w2
        adc     w0, zero
        adc     w1, zero
        rcall   times_sigma
        add     part0, w0
        adc     part1, w1
        adc     part2, zero
        adc     part3, zero
        tst     is_open
        brne    1f
        sub4    s, part             /* P less that */
        movw4   part, s
1:      std4    KF_VAR, part
        movw    sigma0, left0
        rcall   times_sigma
        add     jump0, part2        /* J and the step */
        adc     jump1, part3
        adc     jump2, zero
        adc     jump3, zero
        ldd4    res, KF_ESTIMATE
        ldd     w0, Y+KF_FRACTION
        ldd     w1, Y+KF_FRACTION+1
        brts    1f
        add     w0, part0
        adc     w1, part1
        add4    res, jump, adc
        rjmp    2f
1:      sub     w0, part0
        sbc     w1, part1
        sub4    res, jump, sbc
2:      std     Y+KF_FRACTION, w0
        std     Y+KF_FRACTION+1, w1
        std4    KF_ESTIMATE, res
        ldd     sigma0, Y+KF_NOISE+1
        ldd     sigma1, Y+KF_NOISE+2
        movw    w0, sigma0          /* the cap, in Q5 */
        lsr     w1
        ror     w0
        movw    w2, w0              /* its floor, in Q7 */
        sub     w0, jump5_0
        sbc     w1, jump5_1
        brcs    1f
        .rept   2
        lsl     w0
        rol     w1
        .endr
        cp      w0, w2
        cpc     w1, w3
        brcc    2f
1:      movw    w0, w2
2:      cp      left0, w0
        cpc     left1, w1
        brcc    1f
        movw    w0, left0
1:      ldi     r30, lo8(642)       /* 2^9 sqrt(pi / 2): taught */
        ldi     r31, hi8(642)
        mul16   s0, s1, part0, part1, w0, w1, r30, r31
        clr     r1                  /* what C expects in r1 */
        ldd     w0, Y+KF_NOISE
        movw    w2, sigma0
        sub     s0, w0
        sbc     s1, w2
        sbc     part0, w3
        sbc     part1, zero
        subi    s0, 0x80            /* half up */
        sbci    s1, 0xFF
        sbci    part0, 0xFF
        sbci    part1, 0xFF
        add     w0, s1
        adc     w2, part0
        adc     w3, part1
        ldd     r30, Y+KF_CONFIG
        ldd     r31, Y+KF_CONFIG+1
        ldd     s0, Z+CONFIG_MIN
        ldd     s1, Z+CONFIG_MIN+1
        cp      w2, s0
        cpc     w3, s1
        brcs    1f
        ldd     s0, Z+CONFIG_MAX
        ldd     s1, Z+CONFIG_MAX+1
        cp      w2, s0
        cpc     w3, s1
        brcs    2f
1:      clr     w0
        movw    w2, s0
2:      std     Y+KF_NOISE, w0
        std     Y+KF_NOISE+1, w2
        std     Y+KF_NOISE+2, w3

        .irp    reg, 29, 28, 17, 16, 15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 3, 2
        pop     \reg
        .endr
        ret
        .size   port_weight_kf_adaptive_step, . - port_weight_kf_adaptive_step

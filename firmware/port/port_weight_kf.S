/* SPDX-License-Identifier: MIT */
/* port_weight_kf - the Kalman filter's step. Contract: shared_c/src/port_weight_kf.h
 *
 *   int32_t port_weight_kf_step(weight_kf_t *kf, int32_t measured_counts)
 *                               r25:r24          r23:r20
 *
 * Twice the product plus 2^15 is summed modulo 2^48, of which bytes 2..5 are the step: the gain is
 * doubled first, and as 2 * 32768 does not fit in 16 bits, that gain, which is exactly 1, takes the
 * measurement as it is. Byte 0 is dropped, for it cannot carry into byte 1's rounding. Rounding is
 * the carry out of byte 1's top bit, and goes into the addition to the estimate.
 * The difference is signed in its top byte only: MULSU leaves the product's sign in the carry.
 * Time: constant, but for the gain 1 and beyond 24 bits.
 */

#define d0    r23 /* 2^7 counts, then the difference to the estimate; MULSU wants r16..r23 */
#define d1    r20
#define d2    r21
#define d3    r22
#define g0    r18 /* the gain, doubled */
#define g1    r19
#define sum1  r21 /* bytes of the sum; d2 and d3 are spent when these begin */
#define sum2  r24
#define sum3  r25
#define sum4  r26
#define sum5  r27
#define zero  r22
        /* X: config, then kf.  Z: kf, the gain, kf */

/* weight_kf_t; port_weight_kf_layout.c holds these. The config begins with where the gains are. */
#define KF_CONFIG   0
#define KF_ESTIMATE 2
#define KF_STEP     6
#define KF_CLIPPED  7

        .section .text.port_weight_kf_step, "ax", @progbits
        .global port_weight_kf_step
        .type   port_weight_kf_step, @function
port_weight_kf_step:
        movw    r30, r24
        mov     r24, d3             /* within 24 bits the top byte repeats the sign below it */
        lsl     r24
        sbc     r24, r24
        cpse    r24, d0
        rjmp    beyond
within:
        ld      r26, Z
        ldd     r27, Z+KF_CONFIG+1
        ld      g0, X+
        ld      g1, X+
        ld      r25, X              /* how many gains there are */
        ldd     r24, Z+KF_STEP
        movw    r26, r30
        movw    r30, g0
        add     r30, r24
        adc     r31, r1
        add     r30, r24
        adc     r31, r1
        lpm     g0, Z+
        lpm     g1, Z
        movw    r30, r26
        inc     r24
        cpse    r24, r25            /* else the steady gain is held */
        std     Z+KF_STEP, r24
        clr     d0                  /* counts * 2^8, by naming the bytes anew; halved */
        asr     d3
        ror     d2
        ror     d1
        ror     d0
        lsl     g0
        rol     g1
        brcs    gain_is_one
        ldd     r0, Z+KF_ESTIMATE
        sub     d0, r0
        ldd     r0, Z+KF_ESTIMATE+1
        sbc     d1, r0
        ldd     r0, Z+KF_ESTIMATE+2
        sbc     d2, r0
        ldd     r0, Z+KF_ESTIMATE+3
        sbc     d3, r0

        mulsu   d3, g0              /* bytes 3 and 4, signed */
        mov     sum3, r0
        mov     sum4, r1
        sbc     sum5, sum5
        mulsu   d3, g1              /* bytes 4 and 5 */
        add     sum4, r0
        adc     sum5, r1
        clr     zero
        mul     d2, g0              /* bytes 2 and 3 */
        mov     sum2, r0
        add     sum3, r1
        adc     sum4, zero
        adc     sum5, zero
        mul     d2, g1              /* bytes 3 and 4 */
        add     sum3, r0
        adc     sum4, r1
        adc     sum5, zero
        mul     d0, g0              /* byte 1 */
        mov     sum1, r1
        mul     d1, g1              /* bytes 2 and 3 */
        add     sum2, r0
        adc     sum3, r1
        adc     sum4, zero
        adc     sum5, zero
        mul     d0, g1              /* bytes 1 and 2 */
        add     sum1, r0
        adc     sum2, r1
        adc     sum3, zero
        adc     sum4, zero
        adc     sum5, zero
        mul     d1, g0              /* bytes 1 and 2 */
        add     sum1, r0
        adc     sum2, r1
        adc     sum3, zero
        adc     sum4, zero
        adc     sum5, zero

        lsl     sum1                /* round half up */
        ldd     r0, Z+KF_ESTIMATE
        adc     sum2, r0
        ldd     r0, Z+KF_ESTIMATE+1
        adc     sum3, r0
        ldd     r0, Z+KF_ESTIMATE+2
        adc     sum4, r0
        ldd     r0, Z+KF_ESTIMATE+3
        adc     sum5, r0
        clr     r1                  /* what C expects in r1 */
        movw    r22, sum2
        movw    r24, sum4
store:
        std     Z+KF_ESTIMATE, r22
        std     Z+KF_ESTIMATE+1, r23
        std     Z+KF_ESTIMATE+2, r24
        std     Z+KF_ESTIMATE+3, r25
        ret

gain_is_one:
        mov     r24, d2
        mov     r25, d3
        mov     r22, d0
        mov     r23, d1
        rjmp    store

beyond: push    r30
        push    r31
        movw    r24, r22
        movw    r22, r20
        movw    r20, r30
        subi    r20, lo8(-KF_CLIPPED)
        sbci    r21, hi8(-KF_CLIPPED)
        call    port_clamp_counts
        movw    r20, r22
        movw    r22, r24
        pop     r31
        pop     r30
        rjmp    within
        .size   port_weight_kf_step, . - port_weight_kf_step

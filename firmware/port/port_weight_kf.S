/* SPDX-License-Identifier: MIT */
/* port_weight_kf - the Kalman filter's step. Contract: shared_c/src/port_weight_kf.h
 *
 *   int32_t port_weight_kf_step(int32_t *estimate_q7, int32_t counts, const uint16_t *gain_q15)
 *                               r25:r24               r23:r20         r19:r18
 *
 * Twice the product plus 2^15 is summed modulo 2^48, of which bytes 2..5 are the step: the gain is
 * doubled first, and as 2 * 32768 does not fit in 16 bits, that gain, which is exactly 1, takes the
 * measurement as it is. Byte 0 is dropped, for it cannot carry into byte 1's rounding. Rounding is
 * the carry out of byte 1's top bit, and goes into the addition to the estimate.
 * The difference is signed in its top byte only: MULSU leaves the product's sign in the carry.
 * Time: constant, but for the gain 1.
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
        /* Z: the gain, then the estimate */

        .section .text.port_weight_kf_step, "ax", @progbits
        .global port_weight_kf_step
        .type   port_weight_kf_step, @function
port_weight_kf_step:
        movw    r30, g0
        lpm     g0, Z+
        lpm     g1, Z
        movw    r30, r24
        clr     d0                  /* counts * 2^8, by naming the bytes anew; halved */
        asr     d3
        ror     d2
        ror     d1
        ror     d0
        lsl     g0
        rol     g1
        brcs    gain_is_one
        ld      r0, Z
        sub     d0, r0
        ldd     r0, Z+1
        sbc     d1, r0
        ldd     r0, Z+2
        sbc     d2, r0
        ldd     r0, Z+3
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
        ld      r0, Z
        adc     sum2, r0
        ldd     r0, Z+1
        adc     sum3, r0
        ldd     r0, Z+2
        adc     sum4, r0
        ldd     r0, Z+3
        adc     sum5, r0
        clr     r1                  /* what C expects in r1 */
        movw    r22, sum2
        movw    r24, sum4
store:
        st      Z, r22
        std     Z+1, r23
        std     Z+2, r24
        std     Z+3, r25
        ret

gain_is_one:
        mov     r24, d2
        mov     r25, d3
        mov     r22, d0
        mov     r23, d1
        rjmp    store
        .size   port_weight_kf_step, . - port_weight_kf_step

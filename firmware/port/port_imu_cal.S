/* SPDX-License-Identifier: MIT */
/* port_imu_cal - the nine products of a calibration. Contract: shared_c/src/port_imu_cal.h
 *
 *   bool port_imu_cal(const imu_cal_t *cal, const int16_t raw[3], int16_t true[3])
 *                     r25:r24               r23:r22               r21:r20
 *
 * All three raw values stay in registers, so that true may be the same array. MULSU leaves the sign
 * of its product in the carry, and SBC of zero extends it. Time: 26 cycles a product, with its
 * coefficient's load; the same for all data but where a high byte looks like a rail's.
 */

#define zero r13
#define sum0 r14
#define sum1 r15
#define sum2 r24 /* the upper half, and then the result */
#define sum3 r25
#define dl   r16 /* coefficient; MULS and MULSU want r16..r23 */
#define dh   r17
#define xl   r18
#define xh   r19
#define yl   r20
#define yh   r21
#define zl   r22
#define zh   r23
        /* X: true.  Y: added.  Z: raw, then the matrix.  T: a value stands on a rail */

/* Offsets in imu_cal_t and imu_cal_config_t */
#define CAL_CONFIG    0
#define CAL_ADDED_Q16 2
#define MATRIX_Q16    0

/* T = 1 if the value is 0x7FFF or 0x8000; \hi in r16..r31 */
        .macro  rail lo, hi
        cpi     \hi, 0x7F
        brne    1f
        inc     \lo             ; 0xFF becomes zero ...
        brne    .+2
        set
        dec     \lo             ; ... and is put back
        rjmp    2f
1:      cpi     \hi, 0x80
        brne    2f
        tst     \lo
        brne    2f
        set
2:
        .endm

/* sum += the next coefficient * value */
        .macro  product lo, hi
        ld      dl, Z+
        ld      dh, Z+
        muls    dh, \hi
        add     sum2, r0
        adc     sum3, r1
        mul     dl, \lo
        add     sum0, r0
        adc     sum1, r1
        adc     sum2, zero
        adc     sum3, zero
        mulsu   dh, \lo
        sbc     sum3, zero
        add     sum1, r0
        adc     sum2, r1
        adc     sum3, zero
        mulsu   \hi, dl
        sbc     sum3, zero
        add     sum1, r0
        adc     sum2, r1
        adc     sum3, zero
        .endm

/* One axis: lo and hi are its raw value */
        .macro  row lo, hi
        ld      sum0, Y+
        ld      sum1, Y+
        ld      sum2, Y+
        ld      sum3, Y+
        product xl, xh
        product yl, yh
        product zl, zh
        add     sum2, \lo
        adc     sum3, \hi
        brvc    3f
        ldi     sum2, 0xFF      ; LDI leaves the flags: it looks negative if it was too large
        ldi     sum3, 0x7F
        brmi    3f
        ldi     sum2, 0x00
        ldi     sum3, 0x80
3:      rail    sum2, sum3
        st      X+, sum2
        st      X+, sum3
        .endm

        .section .text.port_imu_cal, "ax", @progbits
        .global port_imu_cal
        .type   port_imu_cal, @function
port_imu_cal:
        push    r13
        push    r14
        push    r15
        push    r16
        push    r17
        push    r28
        push    r29
        movw    r26, r20
        movw    r28, r24
        movw    r30, r22
        ldd     xl, Z+0
        ldd     xh, Z+1
        ldd     yl, Z+2
        ldd     yh, Z+3
        ldd     zl, Z+4
        ldd     zh, Z+5
        ldd     r30, Y+CAL_CONFIG
        ldd     r31, Y+CAL_CONFIG+1
        adiw    r28, CAL_ADDED_Q16
#if MATRIX_Q16
#error "the matrix comes first"
#endif
        clr     zero
        clt
        rail    xl, xh
        rail    yl, yh
        rail    zl, zh
        row     xl, xh
        row     yl, yh
        row     zl, zh
        clr     r25
        clr     r24
        bld     r24, 0
        clr     r1
        pop     r29
        pop     r28
        pop     r17
        pop     r16
        pop     r15
        pop     r14
        pop     r13
        ret
        .size   port_imu_cal, . - port_imu_cal

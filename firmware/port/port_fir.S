/* SPDX-License-Identifier: MIT */
/* port_fir - the FIR's window, and its inner loop. Contract: shared_c/src/port_fir.h
 *
 *   int32_t port_fir_fold(const uint8_t ring[], const fir_config_t *config, uint8_t oldest)
 *                         r25:r24               r23:r22                     r20
 *
 * The sum needs 40 bits, signed (see the contract), so everything here is modulo 2^40: bytes 0..4.
 * Products are gathered in three columns, each 3 bytes wide, and added together once at the end:
 *
 *   column 0    bytes 0..2    s0 * cl                                 unsigned
 *   column 8    bytes 1..3    s1 * cl + s0 * ch                       signed
 *   column 16   bytes 2..4    s2 * cl + s1 * ch + 2^8 s2 * ch         modulo 2^24
 *
 * where s2:s1:s0 is the sum of a sample and its mirror (a carry out of it is worth 2^24 and adds
 * the coefficient to bytes 3 and 4), cl the coefficient's low byte, unsigned, ch its high byte,
 * signed: MULSU leaves the sign of the product in the carry, and SBC of zero extends it.
 * Bounds: column 0 <= pairs * 65025, column 8 in pairs * [-32640, 97410] + 64; both fit in their
 * 3 bytes up to 86 pairs, and a window has 32 at most.
 *
 * The ring's end is met once at most: the older samples are read upwards from `oldest`, the newer
 * ones downwards, and of the two ways to an end of the ring the shorter one is no longer than
 * half of it. So the pairs are done in two runs, with one step across the end between them.
 * Time: 59 cycles a pair, one more where the fold carries.
 */

#define ring_l  r6 /* where the ring begins */
#define ring_h  r7
#define ring_size r8 /* bytes of the ring, odd as the number of taps is; even: no middle is due */
#define rest    r5 /* bytes of the second run + 1; 0: it has begun */
#define acc0_0  r9 /* column 0 */
#define acc0_1  r10
#define acc0_2  r11
#define acc8_0  r16 /* column 8; r16 and r17 take their start values by LDI */
#define acc8_1  r12
#define acc8_2  r13
#define acc16_0 r14 /* column 16 */
#define acc16_1 r15
#define acc16_2 r17
#define s0      r18 /* sample, then folded sample; MULSU wants r16..r23 */
#define s1      r19
#define s2      r20
#define mirror0 r21 /* the mirrored sample ... */
#define mirror1 r22
#define mirror2 r23
#define cl      r22 /* ... and, once it is added, the coefficient */
#define ch      r23
#define left    r24 /* bytes left of the present run */
#define zero    r25
        /* X: older samples, upwards.  Y: newer samples, downwards.  Z: coefficients
         * T: they lie in RAM, else in ROM */

/* fir_config_t and fir_t; port_fir_layout.c holds these. */
#define CONFIG_HALF_Q15 0
#define CONFIG_TAPS     2
#define CONFIG_LOADED   3
#define FIR_CONFIG      0
#define FIR_NEXT        4
#define FIR_WINDOW      5

/*   void port_fir_take(fir_t *fir, int32_t sample_counts, const fir_config_t *twice)
 *                      r25:r24     r23:r20                r19:r18
 * X: a place in the window.  Z: fir.  r24: next.  r25: bytes of a sample, then of all samples
 */
        .section .text.port_fir_take, "ax", @progbits
        .global port_fir_take
        .type   port_fir_take, @function
port_fir_take:
        movw    r30, r24
        ldd     r26, Z + FIR_CONFIG
        ldd     r27, Z + FIR_CONFIG + 1
        clt
        cp      r26, r18
        cpc     r27, r19
        brne    once
        set
once:
        adiw    r26, CONFIG_TAPS
        ld      r24, X
        ldi     r25, 3
        mul     r24, r25
        mov     r25, r0
        clr     r1                  /* what C expects in r1 */
        subi    r22, 0x80           /* + 2^23, modulo 2^24 */
        ldd     r24, Z + FIR_NEXT
        movw    r26, r30
        adiw    r26, FIR_WINDOW
        add     r26, r24
        adc     r27, r1
put:
        st      X+, r20
        st      X+, r21
        st      X+, r22
        brtc    is_put
        clt
        add     r26, r25
        adc     r27, r1
        sbiw    r26, 3
        rjmp    put
is_put:
        subi    r24, -3
        cpse    r24, r25
        rjmp    .+2
        clr     r24
        std     Z + FIR_NEXT, r24
        ret
        .size   port_fir_take, . - port_fir_take

        .section .text.port_fir_fold, "ax", @progbits
        .global port_fir_fold
        .type   port_fir_fold, @function
port_fir_fold:
        push    rest
        push    ring_l
        push    ring_h
        push    ring_size
        push    acc0_0
        push    acc0_1
        push    acc0_2
        push    acc8_1
        push    acc8_2
        push    acc16_0
        push    acc16_1
        push    acc8_0
        push    acc16_2
        push    r28
        push    r29

        movw    r30, r22            /* Z = config */
        movw    ring_l, r24
        movw    r26, r24
        add     r26, r20
        adc     r27, r1
        movw    r28, r26            /* X = Y = the oldest sample, and behind the newest */
        ldd     r18, Z + CONFIG_TAPS
        ldd     r19, Z + CONFIG_LOADED
        bst     r19, 0
        ldd     r22, Z + CONFIG_HALF_Q15
        ldd     r23, Z + CONFIG_HALF_Q15 + 1
        movw    r30, r22
        ldi     r19, 3
        mul     r18, r19
        mov     ring_size, r0
        lsr     r18
        mul     r18, r19
        mov     rest, r0            /* 3 pairs: both runs */
        mov     left, r20
        mov     r19, ring_size
        sub     r19, r20
        cp      r19, left
        brsh    newer_ends_first
        mov     left, r19
newer_ends_first:
        sub     rest, left
        inc     rest
        clr     zero
        clr     acc0_0
        clr     acc0_1
        clr     acc0_2
        ldi     acc8_0, 0x40        /* 2^14: round half up */
        clr     acc8_1
        clr     acc8_2
        clr     acc16_0
        clr     acc16_1
        ldi     acc16_2, 0xC0       /* -2^38: the samples' offset times the taps' sum */
        tst     left
        breq    run_ends

next_pair:
        ld      s0, X+
        ld      s1, X+
        ld      s2, X+
        ld      mirror2, -Y
        ld      mirror1, -Y
        ld      mirror0, -Y
        add     s0, mirror0
        adc     s1, mirror1
        adc     s2, mirror2
times_coefficient:
        brts    from_ram            /* neither this nor a load touches the carry */
        lpm     cl, Z+
        lpm     ch, Z+
with_coefficient:
        brcc    no_carry
        add     acc16_1, cl
        adc     acc16_2, ch
no_carry:
        mul     s0, cl
        add     acc0_0, r0
        adc     acc0_1, r1
        adc     acc0_2, zero
        mul     s1, cl
        add     acc8_0, r0
        adc     acc8_1, r1
        adc     acc8_2, zero
        mul     s2, cl
        add     acc16_0, r0
        adc     acc16_1, r1
        adc     acc16_2, zero
        mulsu   ch, s0
        sbc     acc8_2, zero
        add     acc8_0, r0
        adc     acc8_1, r1
        adc     acc8_2, zero
        mulsu   ch, s1
        sbc     acc16_2, zero
        add     acc16_0, r0
        adc     acc16_1, r1
        adc     acc16_2, zero
        mulsu   ch, s2
        add     acc16_1, r0
        adc     acc16_2, r1
        subi    left, 3
        brne    next_pair

run_ends:
        tst     rest
        breq    pairs_done
        cp      r28, ring_l         /* Y at the ring's beginning? If not, X may be at its end */
        cpc     r29, ring_h
        breq    newer_wraps
        movw    r26, ring_l
        rjmp    second_run
newer_wraps:
        add     r28, ring_size
        adc     r29, zero
second_run:
        mov     left, rest
        clr     rest
        dec     left
        brne    next_pair
pairs_done:
        sbrs    ring_size, 0
        rjmp    all_done
        dec     ring_size
        ld      s0, X+
        ld      s1, X+
        ld      s2, X+
        ldi     left, 3
        clc                         /* the middle sample is folded with nothing */
        rjmp    times_coefficient

from_ram:
        ld      cl, Z+
        ld      ch, Z+
        rjmp    with_coefficient

all_done:
        /* r25:r22 = (sum of the columns) >> 15, that is, bytes 2..4 of twice the sum and its sign.
         * Byte 0 of column 0 takes no part any more; r20 holds byte 1, r21 the sign of column 8. */
        mov     r21, acc8_2
        lsl     r21
        sbc     r21, r21
        mov     r20, acc0_1
        mov     r22, acc0_2
        add     r20, acc8_0
        adc     r22, acc8_1
        adc     acc8_2, zero
        adc     r21, zero
        mov     r23, acc8_2
        mov     r24, r21
        add     r22, acc16_0
        adc     r23, acc16_1
        adc     r24, acc16_2
        lsl     r20
        rol     r22
        rol     r23
        rol     r24
        sbc     r25, r25            /* the sign, from the carry */
        clr     r1                  /* what C expects in r1 */

        pop     r29
        pop     r28
        pop     acc16_2
        pop     acc8_0
        pop     acc16_1
        pop     acc16_0
        pop     acc8_2
        pop     acc8_1
        pop     acc0_2
        pop     acc0_1
        pop     acc0_0
        pop     ring_size
        pop     ring_h
        pop     ring_l
        pop     rest
        ret
        .size   port_fir_fold, . - port_fir_fold

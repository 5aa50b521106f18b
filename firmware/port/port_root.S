/* SPDX-License-Identifier: MIT */
/* port_root - roots and ratios bit by bit. Contract: shared_c/src/port_root.h
 *
 *   uint16_t port_root(uint32_t value)
 *   r25:r24            r25:r22
 *   uint16_t port_ratio_q15(uint16_t part, uint16_t whole)
 *   r25:r24                 r25:r24        r23:r22
 *
 * Time: constant within 2 cycles a bit.
 */

        .section .text.port_root, "ax", @progbits
        .global port_root
        .type   port_root, @function
port_root:
        ldi     r18, 0x00           /* the bit that is tried, in r19:r18 */
        ldi     r19, 0x40
        ldi     r20, 0              /* root, in r21:r20 */
        ldi     r21, 0
1:      or      r20, r18
        or      r21, r19
        mul     r21, r21            /* its square, in r27:r26:r31:r30 */
        movw    r26, r0
        mul     r20, r20
        movw    r30, r0
        mul     r20, r21            /* below 2^15: doubled it fits */
        lsl     r0
        rol     r1
        add     r31, r0
        adc     r26, r1
        brcc    2f
        inc     r27
2:      cp      r22, r30
        cpc     r23, r31
        cpc     r24, r26
        cpc     r25, r27
        brsh    3f
        eor     r20, r18            /* too large: without that bit */
        eor     r21, r19
3:      lsr     r19
        ror     r18
        brcc    1b                  /* until the last bit has left */
        movw    r24, r20
        clr     r1
        ret
        .size   port_root, . - port_root

        .section .text.port_ratio_q15, "ax", @progbits
        .global port_ratio_q15
        .type   port_ratio_q15, @function
port_ratio_q15:
        ldi     r18, 16
1:      cp      r24, r22
        cpc     r25, r23
        brlo    2f
        sub     r24, r22            /* leaves no carry */
        sbc     r25, r23
2:      rol     r20                 /* bits that are not set */
        rol     r21
        lsl     r24                 /* below 2^15: fits */
        rol     r25
        dec     r18
        brne    1b
        movw    r24, r20
        com     r24
        com     r25
        ret
        .size   port_ratio_q15, . - port_ratio_q15

/* SPDX-License-Identifier: MIT */
/* port_wide - upper half of a 64-bit product, and a quotient. Contract: shared_c/src/port_wide.h
 *
 *   uint32_t port_wide_high(uint32_t a, uint32_t b)
 *                           r25:r22     r21:r18
 *
 *   int32_t port_wide_share(int32_t value, uint32_t share_q32)
 *                           r25:r22        r21:r18
 *
 *   uint32_t port_wide_ratio(uint32_t a, uint32_t b)
 *                            r25:r22     r21:r18
 *
 * Sixteen products of bytes, summed column by column in three bytes that take turns; the columns
 * below byte 3 leave their carry only. The result takes a's place, byte by byte as a's are spent.
 * Time: constant. The quotient's bits are the borrows' complement, 22 to 25 cycles each.
 */

#define a0 r22
#define a1 r23
#define a2 r24
#define a3 r25
#define b0 r18
#define b1 r19
#define b2 r20
#define b3 r21
#define x r26
#define y r27
#define z r30
#define zero r31

/* Add one product to the column that stands in \low, its carries in \mid and \high. */
        .macro sum a, b, low, mid, high
        mul     \a, \b
        add     \low, r0
        adc     \mid, r1
        adc     \high, zero
        .endm

        .section .text.port_wide_high, "ax", @progbits
        .global port_wide_share
        .type port_wide_share, @function
port_wide_share:
        sbrs    a3, 7
        rjmp    port_wide_high
        rcall   negate
        rcall   port_wide_high
negate: com     a3
        com     a2
        com     a1
        neg     a0
        sbci    a1, 0xFF
        sbci    a2, 0xFF
        sbci    a3, 0xFF
        ret
        .size port_wide_share, . - port_wide_share

        .global port_wide_high
        .type port_wide_high, @function
port_wide_high:
        clr     zero
        mul     a0, b0
        mov     x, r1
        clr     y
        clr     z
        sum     a0, b1, x, y, z     /* byte 1 */
        sum     a1, b0, x, y, z
        clr     x
        sum     a0, b2, y, z, x     /* byte 2 */
        sum     a1, b1, y, z, x
        sum     a2, b0, y, z, x
        clr     y
        sbrc    z, 7                /* byte 3: half of the result's last digit first */
        inc     x                   /* <= 4: the third byte of a sum of a few products */
        subi    z, 0x80
        sum     a0, b3, z, x, y
        sum     a1, b2, z, x, y
        sum     a2, b1, z, x, y
        sum     a3, b0, z, x, y
        clr     z
        sum     a1, b3, x, y, z     /* byte 4 */
        sum     a2, b2, x, y, z
        sum     a3, b1, x, y, z
        mov     r22, x
        clr     x
        sum     a2, b3, y, z, x     /* byte 5 */
        sum     a3, b2, y, z, x
        mov     r23, y
        mul     a3, b3              /* byte 6 and 7: no carry can leave them */
        add     z, r0
        adc     x, r1
        mov     r24, z
        mov     r25, x
        clr     r1
        ret
        .size port_wide_high, . - port_wide_high

#define q0 r26
#define q1 r27
#define q2 r30
#define q3 r31
#define left r0

        .section .text.port_wide_ratio, "ax", @progbits
        .global port_wide_ratio
        .type port_wide_ratio, @function
port_wide_ratio:
        ldi     q0, 32
        mov     left, q0
1:      lsl     a0
        rol     a1
        rol     a2
        rol     a3
        cp      a0, b0
        cpc     a1, b1
        cpc     a2, b2
        cpc     a3, b3
        brcs    2f
        sub     a0, b0
        sbc     a1, b1
        sbc     a2, b2
        sbc     a3, b3              /* no borrow is left */
2:      rol     q0
        rol     q1
        rol     q2
        rol     q3
        dec     left
        brne    1b
        movw    a0, q0
        movw    a2, q2
        com     a0
        com     a1
        com     a2
        com     a3
        ret
        .size port_wide_ratio, . - port_wide_ratio

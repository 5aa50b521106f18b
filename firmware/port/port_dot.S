/* SPDX-License-Identifier: MIT */
/* port_dot - the inner product of two vectors of three. Contract: shared_c/src/port_dot.h
 *
 *   int32_t port_dot(const int16_t a[3], const int16_t b[3])
 *   r25:r22          r25:r24             r23:r22
 */

#include "port_sums.inc"

        .section .text.port_dot, "ax", @progbits
        .global port_dot
        .type   port_dot, @function
port_dot:
        push    r15
        push    r16
        push    r17
        movw    r26, r24
        movw    r30, r22
        ld      r16, X+
        ld      r17, X+
        ld      r18, X+
        ld      r19, X+
        ld      r20, X+
        ld      r21, X+
        clr     zero
        rcall   port_dot_pairs
        movw    r22, r24
        movw    r24, r26
        clr     r1                  /* what C expects in r1 */
        pop     r17
        pop     r16
        pop     r15
        ret
        .size   port_dot, . - port_dot

/* For assembler: SUM3 = PAIR0..2 . the vector at Z, which goes on behind it; PAIR3 is lost. */
        .global port_dot_pairs
        .type   port_dot_pairs, @function
port_dot_pairs:
        ld      r22, Z+
        ld      r23, Z+
        product SUM3, PAIR0, PAIR3
        ld      r22, Z+
        ld      r23, Z+
        add_product SUM3, PAIR1, PAIR3
        ld      r22, Z+
        ld      r23, Z+
        add_product SUM3, PAIR2, PAIR3
        ret
        .size   port_dot_pairs, . - port_dot_pairs

/* SPDX-License-Identifier: MIT */
/* port_dot - the inner product of two vectors of three. Contract: shared_c/src/port_dot.h
 *
 *   int32_t port_dot(const int16_t a[3], const int16_t b[3])
 *   r25:r22          r25:r24             r23:r22
 */

#include "port_sums.inc"

#define SUM r22, r23, r24, r25

.macro next
        ld      r18, X+
        ld      r19, X+
        ld      r20, Z+
        ld      r21, Z+
.endm

        .section .text.port_dot, "ax", @progbits
        .global port_dot
        .type   port_dot, @function
port_dot:
        push    zero
        clr     zero
        movw    r26, r24
        movw    r30, r22
        next
        product SUM, PAIR1, PAIR2
        clt                         /* twice */
1:      next
        add_product SUM, PAIR1, PAIR2
        brts    2f
        set
        rjmp    1b
2:      clr     r1                  /* what C expects in r1 */
        pop     zero
        ret
        .size   port_dot, . - port_dot

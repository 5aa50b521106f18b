/* SPDX-License-Identifier: MIT */
/* port_clamp - what every filter does to what it is fed. Contract: shared_c/src/port_clamp.h
 *
 *   int32_t port_clamp_counts(int32_t value, uint16_t *clipped)
 *           r25:r22           r25:r22        r21:r20
 *   void port_count(uint16_t *counter)
 *                   r25:r24
 *   int32_t port_to_q7(int32_t value), port_from_q7(int32_t value_q7)
 *           r25:r22            r25:r22
 *
 * Time: 12 cycles where there is nothing to clamp.
 */

#define v0    r22
#define v1    r23
#define v2    r24
#define sign  r25 /* the value's top byte, then the sign in every bit */
#define count0 r18
#define count1 r19

        .section .text.port_clamp_counts, "ax", @progbits
        .global port_clamp_counts
        .type port_clamp_counts, @function
port_clamp_counts:
        mov     r18, v2             /* within 24 bits the top byte repeats the sign below it */
        lsl     r18
        sbc     r18, r18
        cp      r18, sign
        breq    counted
        lsl     sign
        sbc     sign, sign
        mov     v0, sign            /* the rail: 0xFF800000 or 0x007FFFFF */
        com     v0
        mov     v1, v0
        ldi     v2, 0x80
        eor     v2, v0
        movw    r30, r20
        rjmp    count
        .size port_clamp_counts, . - port_clamp_counts

        .global port_count
        .type port_count, @function
port_count:
        movw    r30, r24
count:
        ld      count0, Z
        ldd     count1, Z+1
        subi    count0, 0xFF        /* one more, which is 0 if it was at its maximum */
        sbci    count1, 0xFF
        breq    counted
        st      Z, count0
        std     Z+1, count1
counted:
        ret
        .size port_count, . - port_count

        .section .text.port_q7, "ax", @progbits
        .global port_to_q7
        .type port_to_q7, @function
port_to_q7:
        lsr     r25                 /* up by a byte and down by a bit */
        mov     r25, r24
        mov     r24, r23
        mov     r23, r22
        clr     r22                 /* keeps the carry */
        ror     r25
        ror     r24
        ror     r23
        ror     r22
        ret
        .size port_to_q7, . - port_to_q7

        .global port_from_q7
        .type port_from_q7, @function
port_from_q7:
        subi    r22, 0xC0           /* half of the last digit, then up by a bit, down by a byte */
        sbci    r23, 0xFF
        sbci    r24, 0xFF
        sbci    r25, 0xFF
        lsl     r22
        rol     r23
        rol     r24
        rol     r25
        mov     r22, r23
        mov     r23, r24
        mov     r24, r25
        sbc     r25, r25            /* the sign */
        ret
        .size port_from_q7, . - port_from_q7

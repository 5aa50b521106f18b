/* SPDX-License-Identifier: MIT */
/* port_imu_cal - the nine products of a calibration, and the turn of its axes. Contract:
 * shared_c/src/port_imu_cal.h
 *
 *   bool port_imu_cal(const imu_cal_config_t *config, int16_t vector[3])
 *                     r25:r24                         r23:r22
 *
 * Each row's sum goes onto the stack, since all three rows want the old vector; then they are added
 * to it from the last to the first. The offset is a fourth product, by -2^13: its low byte is zero,
 * so that the half that its high byte makes is enough. MULSU leaves the sign of its product in the
 * carry, and SBC of zero extends it. Time: 33 cycles a product, with its loads; the same for all
 * data but where a value saturates.
 */

#define zero  r15
#define rows  r16 /* to go */
#define cols  r17
#define sum0  r18
#define sum1  r19
#define sum2  r24
#define sum3  r25
#define dl    r20 /* coefficient; MULSU wants r16..r23 */
#define dh    r21
#define vl    r22 /* value */
#define vh    r23
        /* X: vector.  Y: offsets.  Z: matrix, then the end of the vector.  T: clipped */

#define AXES        3
#define OFFSET_Q3   18 /* imu_cal_config_t: behind the matrix */
#define MINUS_2_13H 0xE0
#define HALF_Q16H   0x80

        .section .text.port_imu_cal, "ax", @progbits
        .global port_imu_cal
        .type   port_imu_cal, @function
port_imu_cal:
        push    r15
        push    r16
        push    r17
        push    r28
        push    r29
        movw    r26, r22
        movw    r30, r24
        movw    r28, r24
        adiw    r28, OFFSET_Q3
        clr     zero
        ldi     rows, AXES
1:      clr     sum0
        ldi     sum1, HALF_Q16H
        clr     sum2
        clr     sum3
        ld      dl, Y+
        ld      dh, Y+
        ldi     vh, MINUS_2_13H
        ldi     cols, AXES + 1
        rjmp    3f
2:      ld      vl, X+
        ld      vh, X+
        ld      dl, Z+
        ld      dh, Z+
        mul     dl, vl
        add     sum0, r0
        adc     sum1, r1
        adc     sum2, zero
        adc     sum3, zero
        mulsu   dh, vl
        sbc     sum3, zero
        add     sum1, r0
        adc     sum2, r1
        adc     sum3, zero
3:      mulsu   vh, dl
        sbc     sum3, zero
        add     sum1, r0
        adc     sum2, r1
        adc     sum3, zero
        muls    dh, vh
        add     sum2, r0
        adc     sum3, r1
        dec     cols
        brne    2b
        push    sum2
        push    sum3
        sbiw    r26, 2 * AXES
        dec     rows
        brne    1b

        movw    r30, r26
        adiw    r30, 2 * AXES
        ldi     rows, AXES
        clt
4:      sbiw    r30, 2
        ldd     vl, Z+0
        ldd     vh, Z+1
        movw    dl, vl
        subi    dl, 0xFF        ; 0x7FFF becomes 0, 0x8000 becomes 1
        sbci    dh, 0x7F
        lsr     dl
        or      dl, dh
        brne    5f
        set
5:      pop     dh
        pop     dl
        add     vl, dl
        adc     vh, dh
        brvc    6f
        set
        ldi     vl, 0xFF        ; LDI leaves the flags: it looks negative if it was too large
        ldi     vh, 0x7F
        brmi    6f
        ldi     vl, 0x00
        ldi     vh, 0x80
6:      std     Z+0, vl
        std     Z+1, vh
        dec     rows
        brne    4b
        clr     r24
        bld     r24, 0
        clr     r1
        pop     r29
        pop     r28
        pop     r17
        pop     r16
        pop     r15
        ret
        .size   port_imu_cal, . - port_imu_cal

/* void port_imu_turn(uint8_t orientation, int16_t vector[3])
 *                    r24                  r23:r22
 *
 * A code has the part's axis in bits 0-1 and a sign in bit 2. z = x cross y: its axis is what is
 * left of 0 + 1 + 2, and it is negated by either sign, and where y does not follow x in the circle.
 */

#define x_code   r24
#define y_code   r23
#define z_code   r22
#define code     r25
#define low      r18 /* what `along` gives */
#define high     r19
#define body_x   r20
#define body_xh  r21
#define body_y   r22 /* and r23: where no code is wanted any more */
#define body_yh  r23
#define temp     r26
#define PART_AXIS 3
#define NEGATED   2  /* bit */

        .section .text.port_imu_turn, "ax", @progbits
        .global port_imu_turn
        .type   port_imu_turn, @function
port_imu_turn:
        movw    r30, r22
        mov     code, x_code
        rcall   along
        movw    body_x, low
        mov     y_code, x_code
        lsr     y_code
        lsr     y_code
        lsr     y_code
        mov     z_code, x_code
        andi    z_code, PART_AXIS
        mov     code, y_code
        andi    code, PART_AXIS
        sub     code, z_code    ; y - x: 1 or -2 where y follows x, else -1 or 2
        lsl     z_code
        add     z_code, code    ; x + y
        neg     z_code
        subi    z_code, -3
        sbrc    code, 7
        inc     code            ; odd where y follows x
        mov     temp, x_code
        eor     temp, y_code
        sbrs    code, 0
        com     temp
        andi    temp, 1 << NEGATED
        or      z_code, temp
        mov     code, y_code
        rcall   along
        mov     code, z_code
        movw    body_y, low
        rcall   along
        std     Z+0, body_x
        std     Z+1, body_xh
        std     Z+2, body_y
        std     Z+3, body_yh
        std     Z+4, low
        std     Z+5, high
        ret

along:  mov     r26, code
        andi    r26, PART_AXIS
        lsl     r26
        clr     r27
        add     r26, r30
        adc     r27, r31
        ld      low, X+
        ld      high, X
        sbrs    code, NEGATED
        ret
        com     high
        neg     low
        sbci    high, 0xFF
        brvc    1f
        ldi     low, 0xFF       ; 32768 does not fit
        ldi     high, 0x7F
1:      ret
        .size   port_imu_turn, . - port_imu_turn

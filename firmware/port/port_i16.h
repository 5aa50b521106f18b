/* SPDX-License-Identifier: MIT */
/* port_i16 - sums of 16-bit products, and sums that saturate. AVR: MULS and the overflow flag. */
#ifndef PORT_I16_H
#define PORT_I16_H

#include <stdint.h>

/* sum + a * b; the caller knows that it fits. 22 cycles. */
static inline int32_t port_mac_i16(int32_t sum, int16_t a, int16_t b)
{
    const uint8_t zero = 0U;

    __asm__("muls  %B[a], %B[b]   \n\t"
            "add   %C[s], r0      \n\t"
            "adc   %D[s], r1      \n\t"
            "mul   %A[a], %A[b]   \n\t"
            "add   %A[s], r0      \n\t"
            "adc   %B[s], r1      \n\t"
            "adc   %C[s], %[zero] \n\t"
            "adc   %D[s], %[zero] \n\t"
            "mulsu %B[a], %A[b]   \n\t" /* carry: the product is negative */
            "sbc   %D[s], %[zero] \n\t"
            "add   %B[s], r0      \n\t"
            "adc   %C[s], r1      \n\t"
            "adc   %D[s], %[zero] \n\t"
            "mulsu %B[b], %A[a]   \n\t"
            "sbc   %D[s], %[zero] \n\t"
            "add   %B[s], r0      \n\t"
            "adc   %C[s], r1      \n\t"
            "adc   %D[s], %[zero] \n\t"
            "clr   r1             \n\t"
            : [s] "+&r"(sum)
            : [a] "a"(a), [b] "a"(b), [zero] "r"(zero)
            : "r0");
    return sum;
}

/* a + b, limited to int16. */
static inline int16_t port_add_sat_i16(int16_t a, int16_t b)
{
    __asm__("add   %A[a], %A[b]   \n\t"
            "adc   %B[a], %B[b]   \n\t"
            "brvc  1f             \n\t"
            "ldi   %A[a], 0xff    \n\t"
            "ldi   %B[a], 0x7f    \n\t"
            "brmi  1f             \n\t" /* it looks negative, so it was too large */
            "ldi   %A[a], 0x00    \n\t"
            "ldi   %B[a], 0x80    \n\t"
            "1:                   \n\t"
            : [a] "+d"(a)
            : [b] "r"(b));
    return a;
}

/* a - b, limited to int16. */
static inline int16_t port_sub_sat_i16(int16_t a, int16_t b)
{
    __asm__("sub   %A[a], %A[b]   \n\t"
            "sbc   %B[a], %B[b]   \n\t"
            "brvc  1f             \n\t"
            "ldi   %A[a], 0xff    \n\t"
            "ldi   %B[a], 0x7f    \n\t"
            "brmi  1f             \n\t" /* it looks negative, so it was too large */
            "ldi   %A[a], 0x00    \n\t"
            "ldi   %B[a], 0x80    \n\t"
            "1:                   \n\t"
            : [a] "+d"(a)
            : [b] "r"(b));
    return a;
}

#endif

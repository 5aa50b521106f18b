/* SPDX-License-Identifier: MIT */
/* port_fixed - the wide multiplication. AVR: eight MULs in place of avr-gcc's 64-bit routine. */
#ifndef PORT_FIXED_H
#define PORT_FIXED_H

#include <stdint.h>

/* a * b, all 32 bits. */
static inline uint32_t port_mul_u16(uint16_t a, uint16_t b)
{
    uint32_t      result;
    const uint8_t zero = 0U;

    __asm__("mul   %B[a], %B[b]   \n\t"
            "movw  %C[r], r0      \n\t"
            "mul   %A[a], %A[b]   \n\t"
            "movw  %A[r], r0      \n\t"
            "mul   %A[a], %B[b]   \n\t"
            "add   %B[r], r0      \n\t"
            "adc   %C[r], r1      \n\t"
            "adc   %D[r], %[zero] \n\t"
            "mul   %B[a], %A[b]   \n\t"
            "add   %B[r], r0      \n\t"
            "adc   %C[r], r1      \n\t"
            "adc   %D[r], %[zero] \n\t"
            "clr   r1             \n\t"
            : [r] "=&r"(result)
            : [a] "r"(a), [b] "r"(b), [zero] "r"(zero)
            : "r0");
    return result;
}

/* floor((value * gain_q15 + 2^14) / 2^15).  gain_q15 <= 32768; |product| <= 2^46
 *
 * Twice the product plus 2^15 is summed in six bytes, of which the upper four are the result: the
 * gain is doubled first, and as 2 * 32768 does not fit in 16 bits, that gain, which is exactly 1,
 * is answered without multiplying.
 * The sign: value = u - 2^32 [value < 0] with u unsigned, so that doubled * 2^32 is taken off, the
 * upper two bytes of the sum.  Bytes of the sum: 0 is dropped (it cannot carry into byte 1's
 * rounding), 1 in `low`, 2..5 in the result.
 */
static inline int32_t port_mul_q15(int32_t value, uint16_t gain_q15)
{
    if (gain_q15 >= 0x8000U) { return value; }
    const uint16_t doubled = (uint16_t)(gain_q15 << 1);
    const uint8_t  zero    = 0U;
    int32_t        result;
    uint8_t        low;

    __asm__("mul   %A[v], %A[g]   \n\t" /* byte 0 and 1 */
            "mov   %[low], r1     \n\t"
            "mul   %B[v], %B[g]   \n\t" /* byte 2 and 3 */
            "movw  %A[r], r0      \n\t"
            "mul   %D[v], %A[g]   \n\t" /* byte 3 and 4: with byte 5 cleared below */
            "mov   %C[r], r1      \n\t"
            "clr   %D[r]          \n\t"
            "add   %B[r], r0      \n\t"
            "adc   %C[r], %[zero] \n\t" /* 0xFE + 1 at most: no carry */
            "mul   %D[v], %B[g]   \n\t" /* byte 4 and 5 */
            "add   %C[r], r0      \n\t"
            "adc   %D[r], r1      \n\t"
            "mul   %C[v], %B[g]   \n\t" /* byte 3 and 4 */
            "add   %B[r], r0      \n\t"
            "adc   %C[r], r1      \n\t"
            "adc   %D[r], %[zero] \n\t"
            "mul   %C[v], %A[g]   \n\t" /* byte 2 and 3 */
            "add   %A[r], r0      \n\t"
            "adc   %B[r], r1      \n\t"
            "adc   %C[r], %[zero] \n\t"
            "adc   %D[r], %[zero] \n\t"
            "mul   %A[v], %B[g]   \n\t" /* byte 1 and 2 */
            "add   %[low], r0     \n\t"
            "adc   %A[r], r1      \n\t"
            "adc   %B[r], %[zero] \n\t"
            "adc   %C[r], %[zero] \n\t"
            "adc   %D[r], %[zero] \n\t"
            "mul   %B[v], %A[g]   \n\t" /* byte 1 and 2 */
            "add   %[low], r0     \n\t"
            "adc   %A[r], r1      \n\t"
            "adc   %B[r], %[zero] \n\t"
            "adc   %C[r], %[zero] \n\t"
            "adc   %D[r], %[zero] \n\t"
            "lsl   %[low]         \n\t" /* round half up: bit 15 of the sum, into the carry */
            "adc   %A[r], %[zero] \n\t"
            "adc   %B[r], %[zero] \n\t"
            "adc   %C[r], %[zero] \n\t"
            "adc   %D[r], %[zero] \n\t"
            "sbrc  %D[v], 7       \n\t" /* value < 0: take 2^32 * doubled off */
            "sub   %C[r], %A[g]   \n\t"
            "sbrc  %D[v], 7       \n\t"
            "sbc   %D[r], %B[g]   \n\t"
            "clr   r1             \n\t"
            : [r] "=&r"(result), [low] "=&r"(low)
            : [v] "r"(value), [g] "r"(doubled), [zero] "r"(zero)
            : "r0");
    return result;
}

#endif

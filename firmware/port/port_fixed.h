/* SPDX-License-Identifier: MIT */
/* port_fixed - products. AVR: MULs by hand in place of avr-gcc's routines. */
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

/* a * b, signed, all 32 bits. MULSU takes r16..r23 and leaves its product's sign in the carry. */
static inline int32_t port_mul_i16(int16_t a, int16_t b)
{
    int32_t       result;
    const uint8_t zero = 0U;

    __asm__("muls  %B[a], %B[b]   \n\t"
            "movw  %C[r], r0      \n\t"
            "mul   %A[a], %A[b]   \n\t"
            "movw  %A[r], r0      \n\t"
            "mulsu %B[a], %A[b]   \n\t"
            "sbc   %D[r], %[zero] \n\t"
            "add   %B[r], r0      \n\t"
            "adc   %C[r], r1      \n\t"
            "adc   %D[r], %[zero] \n\t"
            "mulsu %B[b], %A[a]   \n\t"
            "sbc   %D[r], %[zero] \n\t"
            "add   %B[r], r0      \n\t"
            "adc   %C[r], r1      \n\t"
            "adc   %D[r], %[zero] \n\t"
            "clr   r1             \n\t"
            : [r] "=&r"(result)
            : [a] "a"(a), [b] "a"(b), [zero] "r"(zero)
            : "r0");
    return result;
}

/* a^2, unsigned, so that sums of three fit. FMULSU doubles: both middle products at once. */
static inline uint32_t port_square_i16(int16_t a)
{
    uint32_t      result;
    const uint8_t zero = 0U;

    __asm__("muls   %B[a], %B[a]   \n\t"
            "movw   %C[r], r0      \n\t"
            "mul    %A[a], %A[a]   \n\t"
            "movw   %A[r], r0      \n\t"
            "fmulsu %B[a], %A[a]   \n\t"
            "sbc    %D[r], %[zero] \n\t"
            "add    %B[r], r0      \n\t"
            "adc    %C[r], r1      \n\t"
            "adc    %D[r], %[zero] \n\t"
            "clr    r1             \n\t"
            : [r] "=&r"(result)
            : [a] "a"(a), [zero] "r"(zero)
            : "r0");
    return result;
}

/* a * b with |a| < 2^23, of which the lower three bytes are read; the caller bounds the product
 * to 32 bits. */
static inline int32_t port_mul_i24(int32_t a, int16_t b)
{
    const uint8_t low    = (uint8_t)a;
    const int16_t high   = (int16_t)(a >> 8);
    int32_t       result = port_mul_i16(high, b) * 256;
    const uint8_t zero   = 0U;

    __asm__("mul   %[l], %A[b]    \n\t"
            "add   %A[r], r0      \n\t"
            "adc   %B[r], r1      \n\t"
            "adc   %C[r], %[zero] \n\t"
            "adc   %D[r], %[zero] \n\t"
            "mulsu %B[b], %[l]    \n\t"
            "sbc   %D[r], %[zero] \n\t"
            "add   %B[r], r0      \n\t"
            "adc   %C[r], r1      \n\t"
            "adc   %D[r], %[zero] \n\t"
            "clr   r1             \n\t"
            : [r] "+&r"(result)
            : [l] "a"(low), [b] "a"(b), [zero] "r"(zero)
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

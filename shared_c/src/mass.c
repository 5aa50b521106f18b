/* SPDX-License-Identifier: MIT */
#include "mass.h"

#include <stdbool.h>

#include "port_fixed.h"

/* The divisor 2^7 * 2^16 * 1000 is 125 * 2^26. Products and the division are put together from
 * 16-bit products, because the 64-bit routines of avr-gcc are large and slow. */
enum { DIVISOR_ODD = 125 };

#define HALF_DIVISOR ((uint32_t)DIVISOR_ODD << 25)

typedef struct {
    uint32_t low;
    uint32_t high;
} wide_t;

static wide_t multiply(uint32_t a, uint32_t b)
{
    const uint16_t a_low = (uint16_t)a, a_high = (uint16_t)(a >> 16);
    const uint16_t b_low = (uint16_t)b, b_high = (uint16_t)(b >> 16);
    const uint32_t low = port_mul_u16(a_low, b_low);
    /* at most (2^16 - 1)^2 + 2^16 - 1 < 2^32, twice over */
    const uint32_t cross = port_mul_u16(a_high, b_low) + (low >> 16);
    const uint32_t other = port_mul_u16(a_low, b_high) + (uint16_t)cross;
    const uint32_t high  = port_mul_u16(a_high, b_high) + (cross >> 16) + (other >> 16);

    return (wide_t){(other << 16) | (uint16_t)low, high};
}

/* n / 125 for n < 32000: the reciprocal is exact there (proved for every n by the tests). */
static uint8_t divide_by_125(uint16_t n)
{
    const uint16_t reciprocal = 33555U; /* 2^22 / 125, rounded up */

    return (uint8_t)((uint16_t)(port_mul_u16(n, reciprocal) >> 16) >> 6);
}

int32_t mass_from_counts(int32_t net_counts_q7, uint32_t span_ug_per_count_q16)
{
    const bool     negative  = net_counts_q7 < 0;
    const uint32_t magnitude = negative ? 0U - (uint32_t)net_counts_q7 : (uint32_t)net_counts_q7;
    wide_t         product   = multiply(magnitude, span_ug_per_count_q16); /* <= 2^63 - 2^31 */

    /* Half a milligram more, and one part less for a negative: half up is half towards zero. */
    const uint32_t half = HALF_DIVISOR - (negative ? 1U : 0U);
    product.low += half;
    product.high += product.low < half ? 1U : 0U; /* no overflow: 2^63 + 2^32 < 2^64 */

    /* Floor division by 2^26, three bytes and two bits, leaves 38 bits: six in `top` ... */
    const uint8_t upper = (uint8_t)(product.high >> 24);
    const uint8_t top   = upper >> 2;
    uint32_t      rest  = product.high << 8 | product.low >> 24;
    rest                = rest >> 2 | (uint32_t)(uint8_t)(upper << 6) << 24;
    /* ... are divided by 125 byte by byte, as on paper. top < 125, so the first digit is 0. */
    uint32_t quotient  = 0U;
    uint8_t  remainder = top;
    for (uint8_t byte = 0U; byte < 4U; ++byte, rest <<= 8) {
        const uint16_t n     = (uint16_t)((uint16_t)remainder << 8 | (uint8_t)(rest >> 24));
        const uint8_t  digit = divide_by_125(n); /* remainder < 125, so n < 32000, digit < 256 */

        remainder = (uint8_t)(n - (uint16_t)(digit * (uint16_t)DIVISOR_ODD));
        quotient  = quotient << 8 | digit;
    }
    if (negative) { return quotient >= 0x80000000U ? INT32_MIN : -(int32_t)quotient; }
    return quotient > (uint32_t)INT32_MAX ? INT32_MAX : (int32_t)quotient;
}

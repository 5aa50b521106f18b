/* SPDX-License-Identifier: MIT */
#include "stack.h"

#define PAINT 0xC5

extern uint8_t __heap_start; /* the linker's: first byte behind static data */

/* In .init3: after the stack pointer is set, before anything is pushed. Written in assembler, for
 * a C loop might use the very stack it paints. */
void stack_paint(void) __attribute__((naked, used, section(".init3")));
void stack_paint(void)
{
    __asm__ volatile("    ldi r30, lo8(__heap_start)  \n"
                     "    ldi r31, hi8(__heap_start)  \n"
                     "    ldi r24, %[paint]           \n"
                     "    in  r26, __SP_L__           \n"
                     "    in  r27, __SP_H__           \n"
                     "1:  st  Z+, r24                 \n"
                     "    cp  r26, r30                \n"
                     "    cpc r27, r31                \n"
                     "    brsh 1b                     \n"
                     :
                     : [paint] "M"(PAINT)
                     : "r24", "r26", "r27", "r30", "r31", "memory");
}

__attribute__((noinline)) uint16_t stack_free_bytes(void)
{
    const uint8_t *const first = &__heap_start;
    const uint8_t       *byte  = first;

    while (*byte == PAINT) { byte++; } /* ends at the latest at main's return address */
    return (uint16_t)(byte - first);
}

/* SPDX-License-Identifier: MIT */
#include "idle.h"
#include "mpu6050_internal.h"
#include "twi.h"
#include "uno_pins.h"

#include <avr/interrupt.h>
#include <avr/io.h>

static inline __attribute__((always_inline)) void enter(void)
{
    __asm__ volatile("push r24\n\t"
                     "in r24, __SREG__\n\t"
                     "push r24\n\t"
                     "push r25\n\t"
                     "push r30\n\t"
                     "push r31\n\t"
                     "%~call idle_note_waking" ::
                         : "memory");
}

/* INT has moved. From mpu6050_is_due on r24, r25 hold the tick when data were ready: the burst that
 * lies ready is begun, or it is noted that one waits. Work is posted for it, so that the main loop
 * sees a burst that takes too long. */
ISR(IMU_INT_vect, ISR_NAKED)
{
    enter();
    __asm__ volatile(
        "sbis %[pin], %[line]\n\t"
        "rjmp 4f\n\t" /* its end */
        "lds r24, %[count]\n\t"
        "lds r25, %[count] + 1\n"
        ".global mpu6050_is_due\n"
        "mpu6050_is_due:\n\t"
        "sbis %[flags], %[armed]\n\t"
        "rjmp 1f\n\t"
        "cbi %[flags], %[armed]\n\t"
        "sts %[due], r24\n\t"
        "sts %[due] + 1, r25\n\t"
        "sbi %[flags], %[busy]\n\t"
        "ldi r30, %[start]\n\t"
        "sts %[twcr], r30\n\t"
        "rjmp 3f\n"
        "1:\n\t"
        "sbi %[flags], %[work]\n\t"
        "sbic %[flags], %[waits]\n\t"
        "rjmp 2f\n\t"
        "sbi %[flags], %[waits]\n\t"
        "sts %[waiting], r24\n\t"
        "sts %[waiting] + 1, r25\n\t"
        "rjmp 3f\n"
        "2:\n\t"
        "lds r30, %[overruns]\n\t"
        "lds r31, %[overruns] + 1\n\t"
        "adiw r30, 1\n\t"
        "breq 3f\n\t"
        "sts %[overruns] + 1, r31\n\t"
        "sts %[overruns], r30\n"
        "3:\n\t"
        "lds r30, %[period]\n\t"
        "lds r31, %[period] + 1\n\t"
        "add r24, r30\n\t"
        "adc r25, r31\n\t"
        "sts %[compare] + 1, r25\n\t" /* high byte first: the low one takes both over */
        "sts %[compare], r24\n"
        "4:\n\t"
        "%~jmp twi_leave" ::[pin] "I"(_SFR_IO_ADDR(IMU_PIN)),
        [line] "I"(IMU_INT), [count] "n"(_SFR_MEM_ADDR(TCNT1)),
        [flags] "I"(_SFR_IO_ADDR(IDLE_FLAGS)), [armed] "I"(IMU_ARMED_BIT),
        [waits] "I"(IMU_WAITS_BIT), [work] "I"(IDLE_WORK_BIT), [due] "i"(&mpu6050.due),
        [waiting] "i"(&mpu6050.waiting_due), [period] "i"(&mpu6050.period),
        [overruns] "i"(&mpu6050.counters.overruns), [twcr] "n"(_SFR_MEM_ADDR(TWCR)),
        [start] "n"(TWI_START), [busy] "I"(TWI_BUSY_BIT), [compare] "n"(_SFR_MEM_ADDR(OCR1A))
        : "memory");
}

/* No edge has come for a period: data were ready then. */
ISR(TIMER1_COMPA_vect, ISR_NAKED)
{
    enter();
    __asm__ volatile("lds r24, %[compare]\n\t"
                     "lds r25, %[compare] + 1\n\t"
                     "subi r25, %[patience]\n\t"
                     "%~jmp mpu6050_is_due" ::[compare] "n"(_SFR_MEM_ADDR(OCR1A)),
                     [patience] "M"(MPU6050_PATIENCE >> 8)
                     : "memory");
}

/* SPDX-License-Identifier: GPL-3.0-or-later */
/* uno - a simulated Arduino Uno: the contract between the C core and Python.
 *
 * Model     ATmega328P at 16 MHz by libsimavr, with our own USART, TWI, EEPROM and interrupt
 *           timing; an HX711 at DOUT = PD2/INT0, PD_SCK = PD3
 * Formats   time is counted in CPU cycles (62.5 ns) since construction; it never goes back
 * Bad data  a program that runs out of flash or writes outside the address space stops with
 *           UNO_CRASHED; nothing here prints or exits
 * Context   one thread per instance; any number of instances in one process
 *
 * This header is read by cffi: no function macros, no inline bodies, one declaration a line.
 */
#ifndef UNO_H
#define UNO_H

#include <stdint.h>

typedef struct uno uno_t;

enum { UNO_CLOCK_HZ = 16000000 };

enum { UNO_RUNNING = 0, UNO_CRASHED = 1 };

/* Reset causes as the bits of MCUSR (ATmega328P datasheet, section 11.9.1). */
enum {
    UNO_RESET_POWER_ON  = 1,
    UNO_RESET_EXTERNAL  = 2,
    UNO_RESET_BROWN_OUT = 4,
    UNO_RESET_WATCHDOG  = 8
};

/* What the chip and its parts counted since construction. */
typedef struct {
    uint64_t sleep_cycles;      /* spent in SLEEP */
    uint64_t interrupts;        /* entries into any vector */
    uint64_t resets;            /* by any cause, the first power-on not counted */
    uint64_t watchdog_resets;   /* of these, by the watchdog */
    uint64_t tx_bytes;          /* bytes that left the device's shift register */
    uint64_t tx_overwrites;     /* UDR written while the transmit buffer was full: byte lost */
    uint64_t rx_bytes;          /* bytes that arrived in the device's shift register */
    uint64_t rx_overruns;       /* of these, lost for want of room (DOR) */
    uint64_t rx_framing_errors; /* of these, without a stop bit (FE) */
    uint64_t tx_framing_errors; /* bytes the host saw without a stop bit: baud mismatch */
    uint64_t twi_starts;        /* START and repeated START conditions */
    uint64_t twi_bytes;         /* bytes moved, addresses included */
    uint64_t twi_nacks;         /* bytes that nobody acknowledged */
    uint64_t twi_free_clocks;   /* times that the program clocked SCL with the TWI off */
    uint64_t eeprom_writes;     /* cells programmed */
    uint64_t eeprom_ignored;    /* writes attempted while busy or without EEMPE */
} uno_stats_t;

/* What the HX711 counted since construction; the T's are those of its datasheet, p. 5. */
typedef struct {
    uint64_t conversions;        /* DOUT fell with fresh data */
    uint64_t frames_read;        /* conversions whose 25 or more pulses all came in time */
    uint64_t conversions_missed; /* replaced by the next one, not one pulse seen */
    uint64_t frames_short;       /* 1..24 pulses: a communication error */
    uint64_t frames_long;        /* more than 27 pulses: a communication error */
    uint64_t overruns;           /* a conversion completed while its frame was being clocked */
    uint64_t busy_pulses;        /* pulses while no data were ready */
    uint64_t power_downs;        /* PD_SCK high for more than 60 us */
    uint64_t sck_high_too_long;  /* T3 above 50 us without power-down intended: 50..60 us */
    uint64_t sck_high_too_short; /* T3 below 0.2 us */
    uint64_t sck_low_too_short;  /* T4 below 0.2 us */
    uint64_t t1_too_short;       /* PD_SCK rose within 0.1 us after DOUT fell */
    uint64_t sck_high_max_ticks; /* longest PD_SCK high that was no power-down */
    uint64_t sck_high_min_ticks; /* shortest PD_SCK high; UINT64_MAX before the first */
    uint64_t sck_low_min_ticks;  /* shortest PD_SCK low within a frame; UINT64_MAX likewise */
} hx711_stats_t;

/* One conversion as the HX711 knows it. */
typedef struct {
    uint64_t tick;     /* when DOUT fell */
    double   source;   /* the signal at that instant, counts, without noise and faults */
    int32_t  counts;   /* what the frame carries */
    uint8_t  pulses;   /* pulses that this conversion received, 255 = 255 or more */
    uint8_t  gain;     /* 128, 32 (channel B) or 64 */
    uint8_t  settling; /* 1: one of the four that must not be used */
    uint8_t  read;     /* 1: the whole frame was clocked out before the next conversion */
} hx711_record_t;

typedef struct {
    double   rate_hz;        /* conversions a second, the chip's true rate */
    double   jitter_s;       /* rms of each conversion's instant about the even grid */
    double   noise_counts;   /* rms of white noise at gain 128, referred to the output */
    uint64_t seed;           /* of noise and jitter */
    double   update_pulse_s; /* DOUT high before fresh data replace unread ones; 0 = none */
    uint8_t  gain_after_power_down_kept; /* datasheet V2.0: 1 = kept; V1: 0 = back to A/128 */
} hx711_config_t;

/* Misbehaviour on command; all fields zero is a healthy part. */
typedef struct {
    uint8_t  dout_stuck_high;   /* line held high */
    uint8_t  dout_stuck_low;    /* line held low */
    uint8_t  cable_out;         /* not driven at all: the chip's pull-up decides */
    int8_t   rail;              /* +1, -1: input beyond the range */
    uint8_t  lost_pulse;        /* 1..25: this pulse of a frame does not reach the part */
    uint32_t lost_pulse_frames; /* for so many frames */
    uint64_t late_ticks;        /* the next conversion comes so much later, once */
    double   flip_probability;  /* each of the 24 bits is inverted with this probability */
    uint8_t  frozen;            /* conversions go on with the counts of the last one */
    double   noise_counts;      /* rms of more white noise, whatever the gain */
    double   rate_factor;       /* the converter's clock runs so much faster; 0 = 1 */
    uint8_t  restarted;         /* power failed for a moment: the part starts anew, once */
    uint32_t lost_conversions;  /* so many are not shown at all */
    uint8_t  stretched_pulse;   /* 1..25: this pulse of a frame lasts for 60 us and more */
    uint32_t stretched_frames;  /* for so many frames */
} hx711_fault_t;

/* Time between the HX711 and the chip is in ticks; in the Uno a tick is a CPU cycle. */
typedef struct hx711 hx711_t;

/* --- the HX711 alone, driven by edges: for tests of the part --- */
hx711_t *hx711_new(double ticks_per_s, const hx711_config_t *config);
void     hx711_free(hx711_t *hx);
void     hx711_set_constant(hx711_t *hx, double counts);
void     hx711_start(hx711_t *hx, uint64_t tick, double first_conversion_s);
void     hx711_sck(hx711_t *hx, uint64_t tick, uint8_t level);
void     hx711_advance(hx711_t *hx, uint64_t tick);
uint8_t  hx711_dout(const hx711_t *hx);
uint64_t hx711_dout_changed_tick(const hx711_t *hx);
void     hx711_get_stats(const hx711_t *hx, hx711_stats_t *stats);
uint32_t hx711_record_count(const hx711_t *hx);
void     hx711_get_records(const hx711_t *hx, hx711_record_t *records, uint32_t first, uint32_t n);

/* --- the board --- */
/* `source_ctx` goes back to Python when signals are wanted; NULL when out of memory. */
uno_t *uno_new(void *source_ctx, const hx711_config_t *config, uint64_t seed);
void   uno_free(uno_t *uno);
void   uno_flash_write(uno_t *uno, uint32_t addr, const uint8_t *bytes, uint32_t n);
void   uno_flash_read(const uno_t *uno, uint32_t addr, uint8_t *bytes, uint32_t n);
void   uno_set_reset_vector(uno_t *uno, uint32_t addr);
/* Restarts the program; `cause` is one UNO_RESET bit. Power-on and brown-out scramble SRAM. */
void     uno_reset(uno_t *uno, uint8_t cause);
uint8_t  uno_run(uno_t *uno, uint64_t until_cycle);
uint64_t uno_cycle(const uno_t *uno);
uint64_t uno_reset_cycle(const uno_t *uno);
uint32_t uno_pc(const uno_t *uno);
uint16_t uno_sp(const uno_t *uno);
void     uno_peek(const uno_t *uno, uint32_t addr, uint8_t *bytes, uint32_t n);
void     uno_poke(uno_t *uno, uint32_t addr, const uint8_t *bytes, uint32_t n);
void     uno_eeprom_get(const uno_t *uno, uint32_t addr, uint8_t *bytes, uint32_t n);
void     uno_eeprom_set(uno_t *uno, uint32_t addr, const uint8_t *bytes, uint32_t n);
void     uno_get_stats(const uno_t *uno, uno_stats_t *stats);
hx711_t *uno_hx711(uno_t *uno);

/* Signals: a constant, or (constant off) whatever the source callback answers. */
void uno_load_constant(uno_t *uno, double counts);
void uno_load_source(uno_t *uno);
void uno_fault(uno_t *uno, const hx711_fault_t *fault);
void uno_get_fault(const uno_t *uno, hx711_fault_t *fault);

/* Serial line as the host sees it. */
void     uno_uart_host_baud(uno_t *uno, double baud);
void     uno_uart_write(uno_t *uno, const uint8_t *bytes, uint32_t n);
uint32_t uno_uart_backlog(const uno_t *uno);
uint32_t uno_uart_available(const uno_t *uno);
/* Each byte with the cycle at which its stop bit ended; returns how many were given. */
uint32_t uno_uart_read(uno_t *uno, uint8_t *bytes, uint64_t *cycles, uint32_t n);
/* Forgets what has arrived at the host; what the host has still to send. */
void uno_uart_discard(uno_t *uno);
void uno_uart_cancel(uno_t *uno);

/* --- the two-wire bus and what is on it --- */

/* Misbehaviour of the lines; all fields zero is a healthy bus. */
typedef struct {
    uint8_t sda_stuck;  /* held low ... */
    uint8_t sda_clocks; /* ... until SCL was clocked so often with the TWI off; 0 = for ever */
    uint8_t scl_stuck;  /* held low */
    uint8_t deaf;       /* nobody acknowledges anything */
} twi_fault_t;

void uno_twi_set_fault(uno_t *uno, const twi_fault_t *fault);
void uno_twi_get_fault(const uno_t *uno, twi_fault_t *fault);

enum { UNO_PART_IMU = 0, UNO_PART_MAG = 1 };

enum { UNO_MAG_QMC5883L = 0, UNO_MAG_HMC5883L = 1 };

typedef struct {
    uint8_t who_am_i;
    uint8_t int_bit;   /* of port D, where INT is wired; 255 = nowhere */
    double  clock_ppm; /* error of its clock */
    uint8_t trim[4];   /* SELF_TEST_X.. SELF_TEST_A */
} imu_config_t;

typedef struct {
    uint64_t samples;        /* measured */
    uint64_t samples_unread; /* replaced by the next one before any read */
    uint64_t fifo_lost;      /* bytes that did not fit in the FIFO */
    uint64_t resets;         /* power-on, and by command */
} imu_stats_t;

/* An MPU-6050 at 0x68, plugged in; 0 when the bus is full. Its signals are asked of Python. */
uint8_t uno_imu_fit(uno_t *uno, const imu_config_t *config);
/* Out, or in again, which is a power-on. */
void uno_imu_plug(uno_t *uno, uint8_t plugged);
/* INT goes to that bit of port D from now on; beyond 7: nowhere. */
void uno_imu_wire_int(uno_t *uno, uint8_t int_bit);
/* As if it were written over the bus. */
void uno_imu_set_register(uno_t *uno, uint8_t reg, uint8_t value);
/* The signal has changed: values asked for ahead are forgotten. */
void uno_imu_restate(uno_t *uno);
/* Plays n rows of 7 (accelerometer, gyroscope, temperature), which must stay; 0 ends it. */
void uno_imu_play(uno_t *uno, const int16_t *rows, uint32_t n);
/* The row that comes next. */
uint32_t uno_imu_played(const uno_t *uno);
void     uno_imu_registers(const uno_t *uno, uint8_t *regs);
void     uno_imu_get_stats(const uno_t *uno, imu_stats_t *stats);

/* A magnetometer; 0 when there is one already. */
uint8_t uno_mag_fit(uno_t *uno, uint8_t kind);
void    uno_mag_plug(uno_t *uno, uint8_t plugged);
void    uno_mag_registers(const uno_t *uno, uint8_t *regs);

/* A register-file device on the two-wire bus, for tests: `regs` 256 bytes, address 7 bits. */
void uno_twi_attach_registers(uno_t *uno, uint8_t address);
void uno_twi_registers_get(const uno_t *uno, uint8_t *regs);
void uno_twi_registers_set(uno_t *uno, const uint8_t *regs);

/* Waveforms of SCK, DOUT, TX and RX; 0 on success, else errno. */
int uno_vcd_start(uno_t *uno);
int uno_vcd_stop(uno_t *uno, const char *path);

/* --- profiling --- */
typedef struct {
    uint32_t entry; /* flash byte address */
    uint64_t calls;
    uint64_t min_cycles; /* call instruction + body + ret, interrupts taken out */
    uint64_t max_cycles;
    uint64_t total_cycles;
    uint64_t gross_max_cycles; /* interrupts left in */
} uno_function_t;

typedef struct {
    uint64_t calls;
    uint64_t min_cycles; /* entry 4 + jump + body + reti, nested handlers taken out */
    uint64_t max_cycles;
    uint64_t total_cycles;
} uno_vector_t;

typedef struct {
    uint32_t begin_pc; /* of the instruction that cleared the I flag */
    uint32_t end_pc;   /* of the instruction that set it in the longest case */
    uint64_t count;
    uint64_t max_cycles; /* I clear, from the end of one to the end of the other */
    uint64_t total_cycles;
} uno_window_t;

enum { UNO_VECTORS = 26, UNO_WINDOWS_MAX = 128, UNO_FUNCTIONS_MAX = 64 };

/* 0, or -1 when there are more than UNO_FUNCTIONS_MAX entries. */
int      uno_profile_start(uno_t *uno, const uint32_t *entries, uint32_t n);
void     uno_profile_stop(uno_t *uno);
uint32_t uno_profile_functions(const uno_t *uno, uno_function_t *functions);
void     uno_profile_vectors(const uno_t *uno, uno_vector_t *vectors);
uint32_t uno_profile_windows(const uno_t *uno, uno_window_t *windows);
/* Lowest stack pointer, cycles profiled, of them asleep, windows that found no room. */
void uno_profile_totals(const uno_t *uno, uint64_t *totals);

#endif

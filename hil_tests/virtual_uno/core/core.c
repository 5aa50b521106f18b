/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "uno_internal.h"

#include <simavr/sim_core.h>
#include <stdlib.h>
#include <string.h>

enum {
    DOUT_BIT = 2, /* PD2, INT0 */
    SCK_BIT  = 3, /* PD3 */

    MCUSR_ADDR = 0x54,
    SRAM_FIRST = 0x100,

    SYNCHRONISER_CYCLES = 1, /* a pin shows in PINx one clock after it moved (section 14.2.4) */
};

avr_io_t *core_find_io(avr_t *avr, const char *kind, char name)
{
    for (avr_io_t *io = avr->io_port; io; io = io->next) {
        if (strcmp(io->kind, kind) != 0) { continue; }
        if (!name || ((avr_ioport_t *)io)->name == name) { return io; }
    }
    return NULL;
}

static uint8_t memory_read(avr_t *avr, avr_io_addr_t addr, void *param)
{
    (void)param;
    return avr->data[addr];
}

static void memory_write(avr_t *avr, avr_io_addr_t addr, uint8_t v, void *param)
{
    (void)param;
    avr->data[addr] = v;
}

void core_hook(uno_t *uno, uint16_t addr, avr_io_read_t read, avr_io_write_t write)
{
    avr_t *avr = uno->avr;

    avr->io[AVR_DATA_TO_IO(addr)].r.c     = read ? read : memory_read;
    avr->io[AVR_DATA_TO_IO(addr)].r.param = uno;
    avr->io[AVR_DATA_TO_IO(addr)].w.c     = write ? write : memory_write;
    avr->io[AVR_DATA_TO_IO(addr)].w.param = uno;
}

uint8_t core_ones_written(const avr_t *avr, uint8_t v)
{
    const uint8_t high = avr->flash[avr->pc + 1U];

    if (high == 0x98U) { return 0; }                                           /* CBI */
    if (high == 0x9AU) { return (uint8_t)(1U << (avr->flash[avr->pc] & 7U)); } /* SBI */
    return v;
}

uint8_t core_write_latency(const avr_t *avr)
{
    const uint8_t high = avr->flash[avr->pc + 1U];

    return (high & 0xF8U) == 0xB8U ? 1U : 2U; /* OUT takes 1 cycle; SBI, CBI and ST take 2 */
}

/* --- HX711 on its pins --- */

static avr_cycle_count_t hx711_due(avr_t *avr, avr_cycle_count_t when, void *param)
{
    uno_t *uno = param;

    (void)when;
    hx711_advance(uno->hx711, avr->cycle - SYNCHRONISER_CYCLES);
    return hx711_next_tick(uno->hx711) + SYNCHRONISER_CYCLES;
}

static void hx711_rearm(uno_t *uno)
{
    const uint64_t due = hx711_next_tick(uno->hx711) + SYNCHRONISER_CYCLES;
    const uint64_t now = uno->avr->cycle;

    avr_cycle_timer_register(uno->avr, due > now ? due - now : 1U, hx711_due, uno);
}

static void sck_moved(avr_irq_t *irq, uint32_t value, void *param)
{
    uno_t         *uno   = param;
    const uint8_t  level = value & 1U;
    const uint64_t at    = uno->avr->cycle + core_write_latency(uno->avr);

    (void)irq;
    vcd_put(&uno->vcd, VCD_SCK, at, level);
    hx711_sck(uno->hx711, at, level);
    hx711_rearm(uno);
}

static void dout_moved(void *ctx, uint64_t tick, uint8_t level)
{
    uno_t *uno = ctx;

    vcd_put(&uno->vcd, VCD_DOUT, tick, level == HX711_FLOATS ? 1U : level);
    if (level == HX711_FLOATS) {
        pins_float(uno, DOUT_BIT);
    } else {
        pins_drive(uno, DOUT_BIT, level);
    }
}

static void signal_wanted(void *ctx, const uint64_t *ticks, double *counts, uint32_t n)
{
    uno_t *uno = ctx;

    uno_source(uno->source_ctx, ticks, counts, n);
}

/* --- running --- */

/* In place of simavr's own: sleeps to the very cycle of the next event, goes on sleeping when
 * interrupts are off (the chip does; simavr ends the simulation), and lets one instruction run
 * after SEI and RETI, not two. */
static void core_run(avr_t *avr)
{
    uno_t          *uno     = avr->custom.data;
    avr_flashaddr_t next_pc = avr->pc;

    probe_before(uno);
    if (avr->state == cpu_Running) { next_pc = avr_run_one(avr); }
    const avr_cycle_count_t idle_cycles = avr_cycle_timer_process(avr);
    avr->pc                             = next_pc;
    probe_after(uno);

    if (avr->state == cpu_Sleeping) {
        avr->cycle += idle_cycles;
        uno->stats.sleep_cycles += idle_cycles;
        uno->timing.asleep = true;
        return;
    }
    if (avr->interrupt_state) { avr_service_interrupts(avr); }
    timing_after_service(uno);
}

static void scramble_sram(uno_t *uno)
{
    for (uint32_t addr = SRAM_FIRST; addr <= uno->avr->ramend; addr++) {
        uno->scramble        = uno->scramble * 6364136223846793005ULL + 1442695040888963407ULL;
        uno->avr->data[addr] = (uint8_t)(uno->scramble >> 56);
    }
}

/* What simavr's own reset leaves wrong or undone. `mcusr` is what the program will find. */
static void after_reset(uno_t *uno, uint64_t cycle, uint8_t mcusr)
{
    avr_t *avr = uno->avr;

    avr->cycle            = cycle; /* simavr sets it to 0, but reset handlers used the old one */
    avr->run              = core_run;
    avr->data[MCUSR_ADDR] = mcusr;
    uno->reset_cycle      = cycle;
    timing_after_reset(uno);
    pins_after_reset(uno);
    usart_after_reset(uno);
    twi_after_reset(uno);
    eeprom_after_reset(uno);
    parts_after_reset(uno, false);
    probe_after_reset(uno);
    avr->run_cycle_limit = uno->probe.on ? 1U : CORE_RUN_LIMIT_CYCLES;
    hx711_sck(uno->hx711, cycle, 0); /* PD3 is an input now; the part pulls nothing up */
    hx711_restate(uno->hx711);       /* drive DOUT anew, ask again for signals since reset */
    hx711_rearm(uno);
}

void uno_reset(uno_t *uno, uint8_t cause)
{
    avr_t         *avr   = uno->avr;
    const uint64_t cycle = avr->cycle;
    const uint8_t  old   = avr->data[MCUSR_ADDR];
    const bool     power = cause == UNO_RESET_POWER_ON || cause == UNO_RESET_BROWN_OUT;

    eeprom_before_reset(uno, power);
    avr_reset(avr);
    if (power) {
        memset(avr->data, 0, 32);
        scramble_sram(uno);
    }
    uno->stats.resets++;
    if (cause == UNO_RESET_WATCHDOG) { uno->stats.watchdog_resets++; }
    after_reset(uno, cycle, cause == UNO_RESET_POWER_ON ? cause : (uint8_t)(old | cause));
    if (power) {
        hx711_power_on(uno->hx711, cycle);
        hx711_rearm(uno);
        parts_after_reset(uno, true);
    }
}

/* simavr's watchdog puts its own reset in avr->run; it also restarts the watchdog at 16 ms. */
static void watchdog_reset(uno_t *uno)
{
    avr_t         *avr   = uno->avr;
    const uint64_t cycle = avr->cycle;
    const uint8_t  old   = avr->data[MCUSR_ADDR];

    eeprom_before_reset(uno, false);
    avr->run(avr);
    uno->stats.resets++;
    uno->stats.watchdog_resets++;
    after_reset(uno, cycle, (uint8_t)(old | UNO_RESET_WATCHDOG));
}

/* Only there to end a burst of instructions, or a sleep, where the run is to end. */
static avr_cycle_count_t run_ends(avr_t *avr, avr_cycle_count_t when, void *param)
{
    (void)avr;
    (void)when;
    (void)param;
    return 0;
}

uint8_t uno_run(uno_t *uno, uint64_t until_cycle)
{
    avr_t *avr = uno->avr;

    if (avr->cycle >= until_cycle) { return UNO_RUNNING; }
    avr_cycle_timer_register(avr, until_cycle - avr->cycle, run_ends, uno);
    while (avr->cycle < until_cycle) {
        avr->run(avr);
        if (avr->run != core_run) {
            watchdog_reset(uno);
            avr_cycle_timer_register(avr, until_cycle - avr->cycle, run_ends, uno);
        }
        if (avr->state == cpu_Crashed || avr->state == cpu_Done) { return UNO_CRASHED; }
    }
    return UNO_RUNNING;
}

/* --- making and freeing --- */

uno_t *uno_new(void *source_ctx, const hx711_config_t *config, uint64_t seed)
{
    uno_t *uno = calloc(1, sizeof *uno);

    if (!uno) { return NULL; }
    uno->avr = avr_make_mcu_by_name("atmega328p");
    if (!uno->avr || !(uno->hx711 = hx711_new(UNO_CLOCK_HZ, config))) {
        free(uno->avr);
        free(uno);
        return NULL;
    }
    avr_t *avr = uno->avr;

    avr_init(avr);
    avr->frequency   = UNO_CLOCK_HZ;
    avr->log         = LOG_NONE;
    avr->codeend     = avr->flashend;
    avr->custom.data = uno; /* used by nobody: custom.init and deinit stay NULL */
    uno->source_ctx  = source_ctx;
    uno->scramble    = seed;
    timing_init(uno);
    pins_init(uno);
    usart_init(uno);
    twi_init(uno);
    eeprom_init(uno);
    parts_init(uno);
    avr_irq_register_notify(uno->pins.irq_d + SCK_BIT, sck_moved, uno);
    hx711_connect(uno->hx711, dout_moved, signal_wanted, uno);
    uno_reset(uno, UNO_RESET_POWER_ON);
    uno->stats.resets = 0;
    return uno;
}

void uno_free(uno_t *uno)
{
    if (!uno) { return; }
    timing_free(uno);
    avr_terminate(uno->avr);
    free(uno->avr->irq_pool.irq);
    free(uno->avr);
    hx711_free(uno->hx711);
    usart_free(&uno->usart);
    vcd_free(&uno->vcd);
    free(uno);
}

/* --- looking in --- */

void uno_flash_write(uno_t *uno, uint32_t addr, const uint8_t *bytes, uint32_t n)
{
    memcpy(uno->avr->flash + addr, bytes, n);
}

void uno_flash_read(const uno_t *uno, uint32_t addr, uint8_t *bytes, uint32_t n)
{
    memcpy(bytes, uno->avr->flash + addr, n);
}

void uno_set_reset_vector(uno_t *uno, uint32_t addr)
{
    uno->avr->reset_pc = addr;
    uno->avr->pc       = addr;
}

uint64_t uno_cycle(const uno_t *uno)
{
    return uno->avr->cycle;
}

uint64_t uno_reset_cycle(const uno_t *uno)
{
    return uno->reset_cycle;
}

uint32_t uno_pc(const uno_t *uno)
{
    return uno->avr->pc;
}

uint16_t uno_sp(const uno_t *uno)
{
    return (uint16_t)(uno->avr->data[R_SPL] | (uno->avr->data[R_SPH] << 8));
}

void uno_peek(const uno_t *uno, uint32_t addr, uint8_t *bytes, uint32_t n)
{
    memcpy(bytes, uno->avr->data + addr, n);
}

void uno_poke(uno_t *uno, uint32_t addr, const uint8_t *bytes, uint32_t n)
{
    memcpy(uno->avr->data + addr, bytes, n);
}

void uno_get_stats(const uno_t *uno, uno_stats_t *stats)
{
    *stats = uno->stats;
}

hx711_t *uno_hx711(uno_t *uno)
{
    return uno->hx711;
}

void uno_load_constant(uno_t *uno, double counts)
{
    hx711_set_constant(uno->hx711, counts);
}

void uno_load_source(uno_t *uno)
{
    hx711_set_source(uno->hx711);
}

void uno_fault(uno_t *uno, const hx711_fault_t *fault)
{
    hx711_set_fault(uno->hx711, uno->avr->cycle, fault);
    hx711_rearm(uno);
}

void uno_get_fault(const uno_t *uno, hx711_fault_t *fault)
{
    hx711_get_fault(uno->hx711, fault);
}

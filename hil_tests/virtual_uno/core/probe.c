/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "uno_internal.h"

#include <string.h>

enum { OP_RET = 0x9508, OP_RETI = 0x9518, OP_ICALL = 0x9509, RETURN_BYTES = 2 };

static bool is_call(uint16_t op)
{
    return (op & 0xFE0EU) == 0x940EU || (op & 0xF000U) == 0xD000U || op == OP_ICALL;
}

static bool is_out_sph(uint16_t op)
{
    return (op & 0xFE0FU) == 0xBE0EU;
}

static uint16_t opcode_at(const avr_t *avr, uint32_t pc)
{
    return (uint16_t)(avr->flash[pc] | (avr->flash[pc + 1U] << 8));
}

static void note_sp(uno_t *uno)
{
    const uint16_t sp = uno_sp(uno);

    if (sp < uno->probe.sp_min) { uno->probe.sp_min = sp; }
}

/* --- frames --- */

static void push(uno_t *uno, bool handler, uint8_t index, uint64_t start)
{
    probe_t *probe = &uno->probe;

    if (probe->depth == PROBE_DEPTH) { return; }
    probe->frames[probe->depth++] = (probe_frame_t){
        .handler  = handler,
        .index    = index,
        .sp_after = (uint16_t)(uno_sp(uno) + RETURN_BYTES),
        .start    = start};
    if (handler) { probe->handlers++; }
}

static void count_function(uno_function_t *f, uint64_t net, uint64_t gross)
{
    if (!f->calls || net < f->min_cycles) { f->min_cycles = net; }
    if (net > f->max_cycles) { f->max_cycles = net; }
    if (gross > f->gross_max_cycles) { f->gross_max_cycles = gross; }
    f->total_cycles += net;
    f->calls++;
}

static void count_vector(uno_vector_t *v, uint64_t net)
{
    if (!v->calls || net < v->min_cycles) { v->min_cycles = net; }
    if (net > v->max_cycles) { v->max_cycles = net; }
    v->total_cycles += net;
    v->calls++;
}

static void pop(uno_t *uno, bool returned)
{
    probe_t             *probe = &uno->probe;
    const probe_frame_t *frame = &probe->frames[--probe->depth];
    const uint64_t       gross = uno->avr->cycle - frame->start;

    if (!frame->handler) {
        if (returned) {
            count_function(&probe->functions[frame->index], gross - frame->stolen, gross);
        }
        return;
    }
    probe->handlers--;
    if (returned) { count_vector(&probe->vectors[frame->index], gross - frame->stolen); }
    for (uint32_t i = probe->depth; i-- > 0;) {
        probe->frames[i].stolen += gross;
        if (probe->frames[i].handler) { break; } /* its own end takes the sum further out */
    }
}

static void returned(uno_t *uno)
{
    const uint16_t sp = uno_sp(uno);

    while (uno->probe.depth && uno->probe.frames[uno->probe.depth - 1U].sp_after <= sp) {
        pop(uno, uno->probe.frames[uno->probe.depth - 1U].sp_after == sp);
    }
}

static void entered(uno_t *uno, uint16_t op)
{
    probe_t      *probe = &uno->probe;
    const uint8_t found = probe->function_at[(uno->avr->pc >> 1) % PROBE_FLASH_WORDS];

    if (!found) { return; }
    if (!is_call(op)) {
        const uint32_t length = uno->avr->pc - probe->pc;
        if (length == 2U || length == 4U) { return; } /* ran on into it: no call */
        if (probe->depth) {                           /* a loop to the function's own start */
            const probe_frame_t *top = &probe->frames[probe->depth - 1U];
            if (!top->handler && top->index == found - 1U &&
                top->sp_after == uno_sp(uno) + RETURN_BYTES) {
                return;
            }
        }
    }
    push(uno, false, (uint8_t)(found - 1U), probe->began);
}

/* --- windows with interrupts off --- */

static void close_window(uno_t *uno)
{
    probe_t       *probe  = &uno->probe;
    const uint64_t length = uno->avr->cycle - probe->window_began;
    uint32_t       i      = 0;

    probe->window_open = false;
    while (i < probe->window_count && probe->windows[i].begin_pc != probe->window_pc) { i++; }
    if (i == UNO_WINDOWS_MAX) {
        probe->windows_dropped++;
        return;
    }
    uno_window_t *window = &probe->windows[i];
    if (i == probe->window_count) {
        probe->window_count++;
        *window = (uno_window_t){.begin_pc = probe->window_pc};
    }
    window->count++;
    window->total_cycles += length;
    if (length > window->max_cycles) {
        window->max_cycles = length;
        window->end_pc     = probe->pc;
    }
}

static void watch_i_flag(uno_t *uno)
{
    probe_t   *probe   = &uno->probe;
    const bool enabled = uno->avr->sreg[S_I];

    if (probe->was_enabled && !enabled) {
        probe->window_open  = true;
        probe->window_pc    = probe->pc;
        probe->window_began = uno->avr->cycle;
    } else if (!probe->was_enabled && enabled && probe->window_open) {
        close_window(uno);
    }
}

/* --- one step --- */

void probe_before(uno_t *uno)
{
    probe_t     *probe = &uno->probe;
    const avr_t *avr   = uno->avr;

    if (!probe->on) { return; }
    probe->ran         = avr->state == cpu_Running;
    probe->was_enabled = avr->sreg[S_I];
    probe->pc          = avr->pc;
    probe->began       = avr->cycle;
}

void probe_after(uno_t *uno)
{
    probe_t *probe = &uno->probe;

    if (!probe->on || !probe->ran) { return; }
    const uint16_t op = opcode_at(uno->avr, probe->pc);

    if (!is_out_sph(op)) { note_sp(uno); } /* half a stack pointer: SPL follows */
    if (!probe->handlers) { watch_i_flag(uno); }
    if (op == OP_RET || op == OP_RETI) {
        returned(uno);
    } else {
        entered(uno, op);
    }
}

void probe_interrupt(uno_t *uno, uint8_t vector, uint64_t cost)
{
    if (!uno->probe.on || vector >= UNO_VECTORS) { return; }
    note_sp(uno);
    push(uno, true, vector, uno->avr->cycle + cost - TIMING_ENTRY_CYCLES);
}

void probe_after_reset(uno_t *uno)
{
    uno->probe.depth       = 0;
    uno->probe.handlers    = 0;
    uno->probe.window_open = false;
    uno->probe.ran         = false;
}

/* --- contract --- */

int uno_profile_start(uno_t *uno, const uint32_t *entries, uint32_t n)
{
    probe_t *probe = &uno->probe;

    if (n > UNO_FUNCTIONS_MAX) { return -1; }
    memset(probe, 0, sizeof *probe);
    for (uint32_t i = 0; i < n; i++) {
        probe->functions[i].entry                                 = entries[i];
        probe->function_at[(entries[i] >> 1) % PROBE_FLASH_WORDS] = (uint8_t)(i + 1U);
    }
    probe->function_count     = n;
    probe->sp_min             = uno_sp(uno);
    probe->started            = uno->avr->cycle;
    probe->sleep_at_start     = uno->stats.sleep_cycles;
    probe->on                 = true;
    uno->avr->run_cycle_limit = 1;
    uno->avr->run_cycle_count = 1;
    return 0;
}

void uno_profile_stop(uno_t *uno)
{
    probe_t *probe = &uno->probe;

    if (!probe->on) { return; }
    probe->on                 = false;
    probe->cycles             = uno->avr->cycle - probe->started;
    probe->sleep_cycles       = uno->stats.sleep_cycles - probe->sleep_at_start;
    uno->avr->run_cycle_limit = CORE_RUN_LIMIT_CYCLES;
}

uint32_t uno_profile_functions(const uno_t *uno, uno_function_t *functions)
{
    memcpy(functions, uno->probe.functions, sizeof uno->probe.functions);
    return uno->probe.function_count;
}

void uno_profile_vectors(const uno_t *uno, uno_vector_t *vectors)
{
    memcpy(vectors, uno->probe.vectors, sizeof uno->probe.vectors);
}

uint32_t uno_profile_windows(const uno_t *uno, uno_window_t *windows)
{
    memcpy(windows, uno->probe.windows, sizeof uno->probe.windows);
    return uno->probe.window_count;
}

void uno_profile_totals(const uno_t *uno, uint64_t *totals)
{
    totals[0] = uno->probe.sp_min;
    totals[1] = uno->probe.cycles;
    totals[2] = uno->probe.sleep_cycles;
    totals[3] = uno->probe.windows_dropped;
}

/* SPDX-License-Identifier: MIT */
/* faults - what is wrong with the converter, by name, and whether its weight may be trusted.
 *
 * Model     what became of each conversion, in order, and its raw counts
 *             cable_out    no conversion came in time
 *             dout_stuck   DOUT rests low, or counts repeat those before 5 times in a row, which
 *                          the noise of a converter at work does not let them
 *             at_rail      counts are the least or the greatest there are
 *             rate         off the beat twice in a row
 *             frames_lost  a frame was refused, a conversion came off the beat or was dropped in
 *                          mid-run
 *             noise        5 conversions more are loud than are not; or counts that did not stir
 *                          leave by 2048 and are back within two conversions, but for 1024: a spike
 *           A stir is a difference of 512 counts or more. Loud is where 3 of the last 6 stir, and
 *           (1 - 1/z)^4 (1 + 1/z^2) leaves more of the counts than of white noise of noise_counts
 *           rms, which it lets through 14-fold. A load that moves as bodies do, and one that swings
 *           at a quarter of the rate, leave next to nothing; a load step is one stir (notes).
 * End       noise: 4 conversions in a row of which the filter leaves less than an eighth of the
 *           limit; all others: 3 good conversions in a row
 * Trust     none while any holds. Where trust comes back the filters must start anew, because they
 *           have seen what was wrong. Noise below the limit is left to the scale's own judgement.
 * Formats   counts: 24 bits in int32
 * Bad data  is what this is for; update cannot fail
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef FAULTS_H
#define FAULTS_H

#include <stdbool.h>
#include <stdint.h>

enum { FAULTS_MOVES = 6 };

/* Bits of `held` and `seen`, as in messages.toml. */
enum {
    FAULTS_CABLE_OUT   = 1,
    FAULTS_DOUT_STUCK  = 2,
    FAULTS_AT_RAIL     = 4,
    FAULTS_RATE        = 8,
    FAULTS_FRAMES_LOST = 16,
    FAULTS_NOISE       = 32
};

/* What became of a conversion; the first ones are numbered as the driver numbers them. */
typedef enum {
    FAULTS_EVENT_NOTHING,
    FAULTS_EVENT_CONVERSION, /* good as far as the driver can tell */
    FAULTS_EVENT_DROPPED,    /* its counts are not to be used: settling, or read too late */
    FAULTS_EVENT_BAD_FRAME,
    FAULTS_EVENT_TIMED_OUT,
    FAULTS_EVENT_STUCK_LOW,
    FAULTS_EVENT_OFF_BEAT /* it came when none was due; its counts are not to be used */
} faults_event_t;

/* Bits of what faults_update answers. */
enum {
    FAULTS_CHANGED = 1, /* `held` is another than before: tell the host */
    FAULTS_SPOILT  = 2, /* not to be trusted: interrupt the scale before it takes this sample */
    FAULTS_RESTART = 4  /* to be trusted again: start the filters anew with this sample */
};

typedef struct {
    uint8_t held;    /* FAULTS_CABLE_OUT and so on, now */
    uint8_t seen;    /* since faults_init */
    uint8_t noisy;   /* 0..4: loud conversions more than others; under noise, quiet ones to come */
    uint8_t good;    /* conversions in a row, stops at 3 */
    uint8_t equal;   /* counts in a row that repeat, stops at 5 */
    uint8_t stirred; /* of the last moves, the newest in bit 0: a stir */
    bool    in_run;  /* the event before was a conversion to be compared with */
    bool    off;     /* the conversion before was off the beat */
    int16_t noise_limit;         /* what the filter may leave, in 256 counts */
    int16_t moves[FAULTS_MOVES]; /* last differences in 256 counts, limited, the newest first */
    int32_t previous_counts;     /* where in_run */
} faults_t;

/* Nothing is wrong yet. */
void faults_init(faults_t *faults);

/* White noise of more counts rms than this is a fault; 4000 until it is said, at least
 * 400. */
void faults_limit_noise(faults_t *faults, uint16_t noise_counts);

/* Take one event, with its counts if it is a conversion; gives FAULTS_CHANGED and so on as bits. */
uint8_t faults_update(faults_t *faults, faults_event_t event, int32_t counts);

/* A gap on purpose follows, as when the channel is changed: it is no fault. */
void faults_pause(faults_t *faults);

#endif

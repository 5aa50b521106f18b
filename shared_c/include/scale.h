/* SPDX-License-Identifier: MIT */
/* scale - from filtered counts to a weight that one can trust: calibration, zero, tare, stability,
 * display, limits, steps, peak, hold and pieces.
 *
 * Model     mass = m_i + (c - c_i) (m_i+1 - m_i) / (c_i+1 - c_i) between the calibration's points,
 *           its first and last line going on outside; load = mass - zero, net = load - tare
 * Slopes    mg a count Q7 in Q32, rounded down once in scale_init, so that the curve never falls
 *           and nothing is divided later (notes bound the error by 1 mg)
 * Stable    in counts, with a band in counts by the steepest slope, so that masses spread no
 *           further: once every estimate since some instant, for stable_us, lay within the band,
 *           those of the first quarter within half of it; until estimates since then spread over
 *           1.5 bands. What is too far off begins anew, so that no drift stays stable for longer
 * Look      filters lag; so what is measured ahead of them ends stability at once and begins anew,
 *           where it lies beyond 1.75 bands of the estimates' other end, or where its mean over 8
 *           samples is more than half a band from them (while stable, and when the first
 *           quarter is over). While measurements leap by more than 3/16 of a band from one to the
 *           next, four such leaps and a band count, and half a leap where that is more than half a
 *           band: vibration is no movement. While stable the load has moved by less than 2.5 bands
 * Zero      set once, at the first stable mass within 10 % of Max on either side if none is set
 *           yet; by command within 2 % of that; tracked within the same 2 %: while stable, once in
 *           2^18 us, if it is within e/2 of zero then, by at most e/8, 0.48 e/s (R76's 0.5 d/s,
 *           4 %, 20 %, from memory; d = e)
 * Limits    over Max + 9 e and under -under_mg nothing is to be shown: flagged, and never stable
 * Display   net / d, d = digit * 10^-decimals of the unit; worked out when it is asked for: what
 *           was shown then is held until the net mass is further from it than d/2 + hysteresis,
 *           then the nearest, half up
 * Steps     a stable load further from the last stable one than step_mg is one event
 * Formats   counts Q7 and mass mg in -2^30..2^30 - 1, in int32; time us, wrapping;
 *           Max <= 2^29 mg, 536 kg; slope below 128 mg a count
 * Time      arrives with the sample and may be irregular; a gap above gap_us begins anew
 * Bad data  counts and masses beyond their range are limited, but for stability, where differences
 *           of counts come round modulo 2^32; commands answer why they refuse, and then change
 *           nothing; update cannot fail
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef SCALE_H
#define SCALE_H

#include <stdbool.h>
#include <stdint.h>

enum { SCALE_POINTS_MAX = 8, SCALE_DECIMALS_MAX = 6 };

#define SCALE_MAX_MG  536870912L  /* 2^29: 536 kg */
#define SCALE_31_BITS 1073741824L /* 2^30: counts Q7 and masses lie in -2^30..2^30 - 1 */

/* Options of the configuration. */
enum {
    SCALE_INITIAL_ZERO = 1, /* zero at the first stable mass */
    SCALE_TRACK_ZERO   = 2
};

/* Bits of what scale_update answers. */
enum {
    SCALE_STABLE  = 1,
    SCALE_AT_ZERO = 2,  /* the load is within e/4 of zero */
    SCALE_OVER    = 4,  /* blank the display */
    SCALE_UNDER   = 8,  /* blank the display */
    SCALE_STEPPED = 16, /* step_us, step_from_mg and step_to_mg are new */
    SCALE_ZEROED  = 32, /* at the first stable mass or by command */
    SCALE_TARED   = 64,
    SCALE_FROZEN  = 128 /* the display shows what is held, or the peak */
};

typedef enum {
    SCALE_OK,
    SCALE_BAD_COUNT,    /* fewer than 2 points, or more than SCALE_POINTS_MAX */
    SCALE_BAD_POINT,    /* a point is beyond the formats */
    SCALE_NOT_MONOTONE, /* masses must rise, and counts rise or fall all the way */
    SCALE_TOO_STEEP,    /* 128 mg a count or more */
    SCALE_BAD_RANGE,    /* Max, e, the band or under_mg: see scale_config_t */
    SCALE_BAD_DIVISION, /* unit, decimals or digit unknown, or d too small for Max */
    SCALE_BAD_TIME,     /* stable_us or gap_us */
    SCALE_NOT_STABLE,   /* a command wants a stable load */
    SCALE_OUT_OF_RANGE, /* the zero is too far off, or there is nothing to tare */
    SCALE_TOO_LIGHT,    /* the reference for pieces is below 20 e, or a piece is below 2 mg */
    SCALE_UNKNOWN       /* no such view, no pieces */
} scale_status_t;

/* What the display shows. */
typedef enum {
    SCALE_SHOW_LIVE,
    SCALE_SHOW_HELD, /* the net mass when it was asked for */
    SCALE_SHOW_PEAK  /* the greatest net mass since it was asked for */
} scale_show_t;

/* In the caller's memory: it must stay. What each sample needs comes first, as in scale_t: the chip
 * reaches 64 bytes at no cost. */
typedef struct {
    int32_t  max_mg;         /* Max: 1..SCALE_MAX_MG */
    int32_t  interval_mg;    /* e: 1..Max/16 */
    int32_t  under_mg;       /* 0..Max */
    int32_t  step_mg;        /* 0..Max */
    int32_t  stable_band_mg; /* 0..e/2 */
    uint32_t stable_us;      /* 1..2^31 */
    uint32_t gap_us;         /* 1..2^31 */
    uint8_t  points;         /* 2..SCALE_POINTS_MAX */
    uint8_t  unit;           /* SCALE_UNIT_* of scale_units.h */
    uint8_t  decimals;       /* 0..SCALE_DECIMALS_MAX */
    uint8_t  digit;          /* 1, 2 or 5 */
    uint8_t  hysteresis_q8;  /* of d, 0..127 */
    uint8_t  options;        /* SCALE_INITIAL_ZERO, SCALE_TRACK_ZERO */
    uint8_t  spare[2];
    int32_t  point_counts_q7[SCALE_POINTS_MAX]; /* rising or falling strictly */
    int32_t  point_mass_mg[SCALE_POINTS_MAX];   /* rising strictly, |.| <= SCALE_MAX_MG */
} scale_config_t;

typedef struct {
    const scale_config_t *config;
    uint8_t               flags;     /* what scale_update answers */
    uint8_t               show;      /* scale_show_t */
    bool                  fine;      /* d <= 256 mg */
    bool                  falling;   /* counts fall with mass */
    bool                  begun;     /* the band holds a sample */
    bool                  steady;    /* within the band for long enough */
    bool                  settled;   /* settled_mg is known */
    uint8_t               grain;     /* a grain is 2^grain counts Q7 ... */
    uint8_t               band;      /* ... so that this is the band in grains */
    int32_t               anchor_q7; /* where the band began; from there on, in grains: */
    int16_t               low;       /* of the band, -382..0 */
    int16_t               high;      /* 0..382 */
    int16_t               raw;       /* the last measurement, |.| <= 4095 */
    uint16_t              rough_q4;  /* mean leap from one of them to the next: < 2^16 */
    int16_t               lag_q3;    /* mean of how far they are ahead: |.| < 2^15 */
    uint32_t              last_us;   /* of the last sample */
    uint32_t since_us;        /* when the band began; while stable, when zero was tracked last */
    int32_t  mass_mg;         /* of the last sample, by the curve alone */
    int32_t  zero_mg;         /* |.| <= 12 % of Max */
    int32_t  tare_mg;         /* 0..Max */
    int32_t  net_mg;          /* above zero and tare */
    int32_t  kept_mg;         /* net mass as it was when asked for, or the peak */
    uint32_t step_us;         /* when stability ended last: with SCALE_STEPPED, the step's begin */
    int32_t  settled_mg;      /* by the curve alone, the last that was stable */
    int32_t  zero_initial_mg; /* set at the first stable mass, else 0 */
    int32_t  zero_range_mg;   /* 2 % of Max */
    int32_t  divisions;       /* what is shown, in d */
    uint32_t per_division;    /* 1/d in 1/mg: Q40, or Q32 where d is fine */
    int32_t  step_from_mg;    /* loads before and after the last step */
    int32_t  step_to_mg;
    uint16_t steps;                           /* counted, stops at 65535 */
    uint32_t per_piece_q32;                   /* pieces a mg; 0: none were counted out */
    uint32_t slope_q32[SCALE_POINTS_MAX - 1]; /* mg a count Q7 */
} scale_t;

/* Check, precompute, and begin without zero, tare, hold and pieces; if refused, nothing changes. */
scale_status_t scale_init(scale_t *scale, const scale_config_t *config);

/* The mass of any counts by the calibration's curve alone; changes nothing. */
int32_t scale_mass(const scale_t *scale, int32_t counts_q7);

/* Behind scale_init: begin with a zero and a tare of before. `firm`: no zero is set at the first
 * stable mass, for what lies there may be a load. A zero beyond 12 % of Max and a tare beyond Max
 * are passed over. */
void scale_resume(scale_t *scale, int32_t zero_mg, int32_t tare_mg, bool firm);

/* Take one estimate of the filters, and what was measured with it before any filter (where nothing
 * is, the estimate again: then nothing is ahead); gives SCALE_STABLE and so on as bits. */
uint8_t scale_update(scale_t *scale, int32_t counts_q7, int32_t raw_q7, uint32_t device_us);

/* Samples were lost or are not to be trusted: what follows must become stable anew. */
void scale_interrupt(scale_t *scale);

/* Commands; what they change shows with the next sample. */
scale_status_t scale_zero(scale_t *scale);
scale_status_t scale_tare(scale_t *scale);
void           scale_tare_clear(scale_t *scale);
scale_status_t scale_show(scale_t *scale, scale_show_t show);

/* What lies there net is `pieces` pieces. */
scale_status_t scale_count_out(scale_t *scale, uint16_t pieces);

/* Pieces that lie there net, to the nearest, half away from zero; 0 if none were counted out. */
int32_t scale_pieces(const scale_t *scale);

/* What is shown from now on, in 10^-decimals of the unit. */
int32_t scale_shown(scale_t *scale);

#endif

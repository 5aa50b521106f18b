/* SPDX-License-Identifier: MIT */
/* checkweigher - products that pass over the platform: each is weighed once, judged once and
 * counted once.
 *
 * Model     a product enters where the mass reaches enter_mg and has left where it falls below
 *           leave_mg; of the last CHECKWEIGHER_SAMPLES_MAX masses between, those from settle_us
 *           after the entry to tail_us before the end are its settled stretch
 * Weight    mean of the stretch with weights 1 2 3 ... 3 2 1, against oscillation (notes)
 * Result    base + S / W, with base the stretch's first mass, S the weighted sum of differences
 *           from it, 1/W in Q32 rounded down, the quotient rounded, half away from base: within
 *           1 mg of the mean
 * Classes   class k holds limit_mg[k - 1] <= mass < limit_mg[k]; the outer ones are open
 * Unweighed with fewer than samples_min in the stretch, after a gap above gap_us on the platform,
 *           or where a mass of the stretch is over 2^22 mg (4.19 kg) off its first: counted apart
 * Formats   mass mg in int32, limited to |mass| <= 2^30; time us, wrapping; ages in units of 256 us
 * Time      arrives with the sample and may be irregular
 * Bad data  a configuration is refused, and then nothing changes; update cannot fail
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef CHECKWEIGHER_H
#define CHECKWEIGHER_H

#include <stdbool.h>
#include <stdint.h>

enum { CHECKWEIGHER_CLASSES_MAX = 8, CHECKWEIGHER_SAMPLES_MAX = 32 };

#define CHECKWEIGHER_TIME_MAX_US 4000000UL
#define CHECKWEIGHER_GAP_MAX_US  500000UL /* so that ages in the ring stay below 2^16 * 256 us */

/* What checkweigher_update answers. */
typedef enum {
    CHECKWEIGHER_EMPTY,
    CHECKWEIGHER_LOADED,   /* a product is on the platform */
    CHECKWEIGHER_VERDICT,  /* it has left just now: mass_mg and class_at are its */
    CHECKWEIGHER_UNWEIGHED /* it has left just now, and could not be weighed */
} checkweigher_event_t;

/* In the caller's memory: it must stay. */
typedef struct {
    int32_t  limit_mg[CHECKWEIGHER_CLASSES_MAX - 1]; /* rising strictly, |.| <= 2^30 */
    int32_t  enter_mg;                               /* leave_mg < enter_mg <= 2^30 */
    int32_t  leave_mg;                               /* > 0 */
    uint32_t settle_us;                              /* 0..CHECKWEIGHER_TIME_MAX_US */
    uint32_t tail_us;                                /* the same */
    uint32_t gap_us;                                 /* 1..CHECKWEIGHER_GAP_MAX_US */
    uint8_t  classes;                                /* 1..CHECKWEIGHER_CLASSES_MAX */
    uint8_t  samples_min;                            /* 1..CHECKWEIGHER_SAMPLES_MAX */
} checkweigher_config_t;

typedef struct {
    const checkweigher_config_t *config;
    bool                         loaded;
    bool                         broken;      /* a gap since the product settled */
    uint8_t                      next;        /* where the next mass goes */
    uint8_t                      held;        /* masses in the ring */
    uint8_t                      class_at;    /* of the last product weighed */
    uint8_t                      samples;     /* in its stretch */
    uint16_t                     unweighed;   /* products, stops at 65535 */
    uint32_t                     last_us;     /* of the last sample */
    uint32_t                     entered_us;  /* of the product on the platform, or the last */
    uint32_t                     left_us;     /* of the last product */
    uint32_t                     interval_us; /* mean from end to end of products, 1/8 each */
    int32_t                      mass_mg;     /* of the last product weighed */
    uint32_t                     weighed;     /* products */
    uint32_t                     counts[CHECKWEIGHER_CLASSES_MAX]; /* products of each class */
    int32_t  ring_mg[CHECKWEIGHER_SAMPLES_MAX];    /* masses since the product settled */
    uint16_t ring_256us[CHECKWEIGHER_SAMPLES_MAX]; /* when they came */
} checkweigher_t;

/* Begin with all counts zero; false and nothing changed where the configuration is unlawful. */
bool checkweigher_init(checkweigher_t *checkweigher, const checkweigher_config_t *config);

/* Take one mass, as scale gives it. */
checkweigher_event_t checkweigher_update(checkweigher_t *checkweigher, int32_t mass_mg,
                                         uint32_t device_us);

/* Products a minute, Q8, by interval_us; 0 before the second product, at most 65535. */
uint16_t checkweigher_per_minute_q8(const checkweigher_t *checkweigher);

#endif

/* SPDX-License-Identifier: MIT */
/* checkweigher - products that pass over the platform: each is weighed once, judged once and
 * counted once.
 *
 * Model     a product enters where the mass reaches enter_mg and has left where it falls below
 *           leave_mg. Of the masses from settle_us after the entry to tail_us before the end the
 *           first CHECKWEIGHER_SAMPLES_MAX are its stretch; they come evenly, so that the k-th
 *           from the end is k times the last interval old
 * Weight    the platform rings: the stretch is a constant and one damped tone, unknown in frequency
 *           and damping. Smoothed by 1 4 6 4 1, its second difference is -g (x - weight) - b d, d
 *           the difference over two samples; least squares for b, g and the weight: second-order
 *           linear prediction, with the constant (notes). Where there is no such tone (g <= 1/16:
 *           below 3.6 Hz at 90 samples a second), the mean
 * Classes   class k holds limit_mg[k - 1] <= mass < limit_mg[k]; the outer ones are open. Who wants
 *           the number of each counts the verdicts
 * Unweighed with fewer than samples_min in the stretch, after a gap above gap_us or an interrupt on
 *           the platform, or where a mass is over twice the stretch's first: counted
 * When      a verdict comes with the third sample after the end; until then no mass of the next
 *           product is held, and it does not leave. No call is long
 * Formats   mass mg in int32, at most 2^30; time us, wrapping, no setting above 2^22. The stretch
 *           is kept in units between 2^-14 and 2^-13 of its first mass (at least 2 mg); its weight
 *           is a number of half units from that
 * Bad data  a configuration that contradicts itself is refused, and then nothing changes; its
 *           ranges are the caller's to keep. update cannot fail
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef CHECKWEIGHER_H
#define CHECKWEIGHER_H

#include <stdbool.h>
#include <stdint.h>

enum {
    CHECKWEIGHER_CLASSES_MAX = 8,
    CHECKWEIGHER_SAMPLES_MAX = 32,
    CHECKWEIGHER_SAMPLES_MIN = 12, /* a tone in fewer cannot be told from noise */
    CHECKWEIGHER_SUMS        = 11
};

/* What checkweigher_update answers. */
typedef enum {
    CHECKWEIGHER_EMPTY,
    CHECKWEIGHER_LOADED,    /* a product is on the platform */
    CHECKWEIGHER_VERDICT,   /* on the one that left last: mass_mg and class_at are its */
    CHECKWEIGHER_UNWEIGHED, /* it has left just now, and cannot be weighed */
} checkweigher_event_t;

/* In the caller's memory: it must stay. */
typedef struct {
    int32_t  limit_mg[CHECKWEIGHER_CLASSES_MAX - 1]; /* those that count rise strictly */
    int32_t  enter_mg;                               /* above leave_mg */
    int32_t  leave_mg;                               /* above 0 */
    uint32_t settle_us;
    uint32_t tail_us;
    uint32_t gap_us;      /* below two intervals of the converter, so that masses come evenly */
    uint8_t  classes;     /* 1..CHECKWEIGHER_CLASSES_MAX */
    uint8_t  samples_min; /* CHECKWEIGHER_SAMPLES_MIN.._MAX */
} checkweigher_config_t;

typedef struct {
    const checkweigher_config_t *config;
    bool                         loaded;
    bool                         broken;     /* a gap or an interrupt since it entered */
    uint8_t                      pending;    /* steps to go until the verdict */
    uint8_t                      held;       /* masses of the product there, stops at 255 */
    uint8_t                      class_at;   /* of the last product weighed */
    uint8_t                      samples;    /* in the stretch of the last that left */
    uint8_t                      shift;      /* off is in units of 2 * 2^shift mg */
    uint8_t                      up;         /* the smoothed are off * 2^up / 8, about the mean */
    uint16_t                     unweighed;  /* products, stops at 65535 */
    uint32_t                     weighed;    /* products */
    uint32_t                     last_us;    /* of the last sample */
    uint32_t                     entered_us; /* of the product on the platform, or the last */
    uint32_t                     left_us;    /* of the last product */
    uint32_t                     interval_32us; /* mean from end to end, 1/8 each */
    int32_t                      mass_mg;       /* of the last product weighed */
    int32_t                      base_mg;       /* first mass held */
    int32_t                      sum;           /* of the inner smoothed, about the first */
    union {                                     /* one after the other */
        int16_t off[CHECKWEIGHER_SAMPLES_MAX];  /* masses from base_mg, in units */
        int32_t sums[CHECKWEIGHER_SUMS];        /* of those, and what is solved from them */
    };
} checkweigher_t;

/* Begin with all counts zero; false and nothing changed where limits do not rise or leave_mg is not
 * below enter_mg. */
bool checkweigher_init(checkweigher_t *checkweigher, const checkweigher_config_t *config);

/* Take one mass, as the calibration's curve gives it: of a converter's sample that no filter has
 * seen, for every filter here is too slow. */
checkweigher_event_t checkweigher_update(checkweigher_t *checkweigher, int32_t mass_mg,
                                         uint32_t device_us);

/* What lies on the platform cannot be weighed any more: samples were lost or are not to be trusted.
 * Without a product there, nothing. */
void checkweigher_interrupt(checkweigher_t *checkweigher);

/* Products a minute, Q8, by interval_32us; 0 before the second product, at most 65535. */
uint16_t checkweigher_per_minute_q8(const checkweigher_t *checkweigher);

#endif

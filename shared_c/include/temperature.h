/* SPDX-License-Identifier: MIT */
/* temperature - takes what a load cell's zero and span drift with temperature off its raw counts.
 *
 * Settings  temperature_on, temperature_reference_centi, temperature_origin_counts,
 *           temperature_zero_counts_per_k_q4, temperature_span_ppm_per_k_q4: the fields of
 *           temperature_config_t, in this order of meaning, off by default
 * Model     c' = c - zero dT - span dT (c - origin), dT = T - reference: a straight line each for
 *           zero and span, as OIML R60 states them (minimum dead load output and sensitivity).
 *           origin is what the converter gives with nothing on, at the reference temperature
 * Where     before the FIR, which takes whole counts: the one rounding there is half a count at the
 *           most, 1.2 mg of a 5 kg cell, and every filter behind it, the scale's curve and what is
 *           weighed beside the filters then know one temperature only, the reference
 * Smoothing the thermometer's readings, about one a second: T += limited(reading - T) / 16, so that
 *           a time constant of 16 readings hides its noise, and one wrong reading moves T by no
 *           more than 0.25 K. The first reading is taken as it is
 * Formats   temperature: 1/100 degC in int16, -40.00..85.00    counts: 24 bits in int32
 *           zero: counts/K, Q4    span: ppm/K, Q4, |span| <= 250 ppm/K
 * Rounding  T half up to 1/200 K, then to 1/100 K; zero dT in Q7, span dT as a share in Q32, that
 *           share of (c - origin) in Q7, each half away from zero; c' half up to a count
 * Bad data  a reading outside the range is refused and counted in `refused`; without any reading,
 *           or switched off, counts are passed on as they are; a result beyond 24 bits is clamped
 *           and counted in `clipped`.  A configuration from outside is asked with
 *           temperature_is_lawful before it is used; the ranges of settings.toml are its bounds
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef TEMPERATURE_H
#define TEMPERATURE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t origin_counts;        /* with nothing on, at the reference; within 24 bits */
    int16_t reference_centi;      /* 1/100 degC */
    int16_t zero_counts_per_k_q4; /* what the zero rises by when it gets warmer */
    int16_t span_ppm_per_k_q4;    /* what the span rises by */
    uint8_t on;                   /* 0: counts are passed on */
} temperature_config_t;

typedef struct {
    const temperature_config_t *config;
    int32_t                     zero_q7;  /* counts to take off for the zero, at this temperature */
    int32_t                     span_q32; /* share of (c - origin) to take off for the span */
    bool                        known;    /* there was a reading */
    int16_t                     smoothed_q1; /* 1/100 degC */
    uint16_t                    refused;     /* readings out of range, stops at 65535 */
    uint16_t                    clipped;     /* results beyond 24 bits, stops at 65535 */
} temperature_t;

/* The bounds above hold, so that nothing overflows. */
bool temperature_is_lawful(const temperature_config_t *config);

/* Begin without a temperature.  config must be lawful, and stay where it is. */
void temperature_init(temperature_t *temperature, const temperature_config_t *config);

/* The configuration has changed where it is: takes effect with the next correction. */
void temperature_refresh(temperature_t *temperature);

/* Take one reading of the thermometer. */
void temperature_update(temperature_t *temperature, int16_t measured_centi);

/* The temperature that corrections are made for; only if `known`. */
int16_t temperature_centi(const temperature_t *temperature);

/* Correct one raw count. */
int32_t temperature_correct(temperature_t *temperature, int32_t raw_counts);

#endif

/* SPDX-License-Identifier: MIT */
/* led - the board's own LED.
 *
 * Context   main loop
 */
#ifndef LED_H
#define LED_H

#include <stdbool.h>

void led_init(void); /* lit, until somebody knows better */
void led_set(bool on);

#endif

/* SPDX-License-Identifier: MIT */
/* version - what HELLO says of this image.
 *
 * Formats   build: the first 8 hex digits of the commit as a number, 0 where the build does not
 *           know it or the sources were changed since. The Makefile passes it, only to those
 *           sources that need it.
 */
#ifndef VERSION_H
#define VERSION_H

/* Macros, because text.c makes text of them. */
#define VERSION_MAJOR 0
#define VERSION_MINOR 1
#define VERSION_PATCH 0

#ifndef VERSION_BUILD
#define VERSION_BUILD 0x0
#endif

#endif

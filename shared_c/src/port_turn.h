/* SPDX-License-Identifier: MIT */
/* port_turn - one step of an attitude filter: rates to turn, quaternion, rows, level acceleration.
 *
 * Model     in this order, in exact integers; >> is floor; carryN adds a remainder to its argument,
 *           keeps the lowest N bits as the new one and goes on with those above:
 *   sample += 1;  axis = sample mod 2;  a = east, north for axis 0, 1;  b = the other one
 *   mean   += lowpass_q16 carry16(level_q14 + a . acc - 2 mean)            of level_w[axis],
 *             limited to -2^27..2^27 - 1;  level_q14 is of the sample before, and
 *   level_q14 = b . acc                                                    for the next
 *   correct_q19 = carry16(+-correct_q18 (mean >> 8))                       - for axis 0, + for 1,
 *             limited to -512..511;  where acc is zero, instead: mean stays, correct_q19 = 0
 *   rate    = carry16(2^16 gyr - bias_q16), limited to int16
 *   loss    = carry16(square carry16(rate . rate) + 2^9 norm_error)        Q17: 1 - cosine
 *   scale   = carry16(2^16 gyro_q33 - cubic loss)                          sine for angle
 *   turn_i  = carry16(scale rate_i + correct_q19 b_i)                      half angles, Q17
 *   quat   += (quat_q14 (-loss, turn) + 1) >> 1                            quaternion product, Q31
 *   quat_q14 = carry8(quat >> 8), after each component
 *   east, north = rows of the rotation matrix of quat_q14, from sums of products in Q28 less their
 *             last byte, rounded half up
 *   norm_error = (|quat_q14|^2 - 2^28) >> 8
 * Flags     MAHONY_ACC_ZERO: all of acc is zero;  MAHONY_RAILED: the upper byte of one of gyr or
 *           acc is at its own end.  Also the result
 * Formats   gyro_q33 <= 16128, correct_q18 <= 4095, norm of the quaternion 1 within 2^-8: then
 *           |turn_i| <= 2^13 and nothing overflows (notes/mahony.md)
 */
#ifndef PORT_TURN_H
#define PORT_TURN_H

#include <stdint.h>

#include "mahony.h"

uint8_t port_turn(mahony_step_t *step, const int16_t gyro_b_counts[3],
                  const int16_t acc_b_counts[3], const int32_t bias_q16[3]);

#endif

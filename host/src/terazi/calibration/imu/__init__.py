# SPDX-License-Identifier: MIT
"""Calibration of the IMU: from standing still in several positions, and from being turned about.

standstill      when a board lies still
positions       which way up it lies, and what is missing yet
accelerometer   nine constants from gravity's length
gyroscope       bias, and a matrix from the turns between positions
magnetometer    hard and soft iron from an ellipsoid
quantise        constants as the device's settings, and what its integers make of them
fit             all of these over a sitting: settings, residuals, refusals
show            what came of it, for people and scripts
board           a live board's raw samples
level           how the part stands on its board
axes            how the magnetometer sits beside it
rehearsal       simulated boards, and what a calibration leaves of their errors
dialogue        the conversation
recording       a recording in place of a live board
self_test       the part's own test beside its trim codes
"""

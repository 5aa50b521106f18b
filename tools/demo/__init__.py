# SPDX-License-Identifier: MIT
"""``./dev demo``: a virtual Uno weighs, is logged, replayed and reported as a real one would be."""

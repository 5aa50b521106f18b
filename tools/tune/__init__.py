# SPDX-License-Identifier: MIT
"""Where the filters' settings come from: searched on recordings, judged on those left out."""

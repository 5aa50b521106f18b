# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the compiled core."""

import sys

from virtual_uno.build import BUILD, MODULE

if str(BUILD) not in sys.path:
    sys.path.append(str(BUILD))
try:
    import _virtual_uno
except ModuleNotFoundError as error:
    raise ImportError(
        f"{MODULE} is not built: run  python -m virtual_uno.build  (needs libsimavr-dev)"
    ) from error

ffi = _virtual_uno.ffi
lib = _virtual_uno.lib

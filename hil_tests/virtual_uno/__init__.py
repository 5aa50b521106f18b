# SPDX-License-Identifier: GPL-3.0-or-later
"""A simulated Arduino Uno that runs the real firmware, with an HX711 on its pins.

``Uno`` is the lock-step interface for tests; ``python -m virtual_uno`` offers the same board on
a pseudo-terminal. The C core must have been built once: ``python -m virtual_uno.build``.
"""

__all__ = ["Hx711", "Uno", "UnoCrashed"]


def __getattr__(name):
    # Late, so that ``virtual_uno.build`` can be imported before there is anything to load.
    if name == "Hx711":
        from virtual_uno.hx711 import Hx711

        return Hx711
    if name in __all__:
        from virtual_uno import uno

        return getattr(uno, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

# SPDX-License-Identifier: MIT
"""What every step-wise class of a C module shares: a state that can be saved and copied."""

from __future__ import annotations

from typing import Self

from terazi.cshared._cshared import ffi


class CState:
    """A C state, ``_c``, beside the constant configuration that it points to, ``_config``, or None
    where what is configured is part of the state."""

    _config = None

    @property
    def _configured(self):
        """The struct that holds the pointer to the configuration."""
        return self._c

    def save(self) -> bytes:
        """State, for restore() on one of the same configuration, in the same process."""
        return bytes(ffi.buffer(self._c))

    def restore(self, state: bytes) -> None:
        """Continue where save() was called; what is configured within the state comes along."""
        if len(state) != ffi.sizeof(self._c[0]):
            raise ValueError(f"not the state of a {type(self).__name__}")
        ffi.buffer(self._c)[:] = state
        if self._config is not None:
            self._configured.config = self._config

    def copy(self) -> Self:
        """Another one in the same state."""
        twin = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)  # configuration is constant: shared
        twin._c = ffi.new(ffi.typeof(self._c), self._c[0])
        return twin

# SPDX-License-Identifier: GPL-3.0-or-later
"""What lies on the scale over time, for the pseudo-terminal program."""

import importlib
import pathlib
import sys

import numpy as np

from virtual_uno.signals import as_function


class ScenarioError(ValueError):
    """The scenario cannot be read; the message is one line for a person."""


class Scenario:
    """``load_g(t_s)`` is what the cell feels, ``truth_g(t_s)`` what a perfect scale would say.

    ``temperature_c(t_s)`` is what an IMU's thermometer feels, or None.
    """

    def __init__(self, load_g, truth_g=None, temperature_c=None):
        self.load_g = as_function(load_g)
        self.truth_g = self.load_g if truth_g is None else as_function(truth_g)
        self.temperature_c = None if temperature_c is None else as_function(temperature_c)


def read_scenario(spec):
    """From ``FILE.npz``, ``module:function`` or a number of grams.

    An npz holds ``load_g`` and ``rate_hz``, or ``load_g`` and ``t_s`` (seconds, rising), and may
    hold ``truth_g`` of the same length, the load without vibration, and ``temperature_c``. A
    function takes seconds since reset, as an array or a number, and gives grams; it may bear both
    as attributes of these names.
    """
    try:
        return Scenario(float(spec))
    except ValueError:
        pass
    if spec.endswith(".npz"):
        return _from_npz(pathlib.Path(spec))
    module_name, colon, name = spec.partition(":")
    if not colon:
        raise ScenarioError(f"scenario {spec!r} is neither FILE.npz, module:function nor grams")
    if "" not in sys.path:
        sys.path.insert(0, "")  # the caller's folder, as for python -m
    try:
        function = getattr(importlib.import_module(module_name), name)
    except (ImportError, AttributeError) as error:
        raise ScenarioError(f"scenario {spec!r}: {error}") from error
    if not callable(function):
        raise ScenarioError(f"scenario {spec!r} is no function")
    truth_g, temperature_c = (
        getattr(function, name, None) for name in ("truth_g", "temperature_c")
    )
    return Scenario(function, truth_g, temperature_c)


def _from_npz(path):
    try:
        with np.load(path) as arrays:
            held = {name: np.asarray(arrays[name], float) for name in arrays.files}
    except (OSError, ValueError) as error:
        raise ScenarioError(f"scenario {path}: {error}") from error
    if "load_g" not in held or not held.keys() & {"rate_hz", "t_s"}:
        raise ScenarioError(f"scenario {path}: it needs load_g and either rate_hz or t_s")
    load_g = held["load_g"]
    at_s = held.get("t_s")
    if at_s is None:
        at_s = np.arange(len(load_g)) / float(held["rate_hz"])
    truth_g = held.get("truth_g", load_g)
    warm_c = held.get("temperature_c")
    series = [at_s, truth_g] + ([] if warm_c is None else [warm_c])
    if load_g.ndim != 1 or not load_g.size or any(each.shape != load_g.shape for each in series):
        raise ScenarioError(
            f"scenario {path}: load_g, t_s, truth_g and temperature_c differ in length"
        )
    return Scenario(
        lambda t_s: np.interp(t_s, at_s, load_g),
        lambda t_s: np.interp(t_s, at_s, truth_g),
        None if warm_c is None else lambda t_s: np.interp(t_s, at_s, warm_c),
    )

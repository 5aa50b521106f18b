# SPDX-License-Identifier: MIT
"""A budget line fails when it is exceeded, and cannot be left unmeasured."""

import pytest

from tools.measure.compiler import is_reference
from tools.measure.limits import compare, load_limits
from tools.measure.sizes import FLASH_SECTIONS, parse_sections


def test_exceeded_line_is_found_in_a_nested_table():
    lines = list(compare({"flash_bytes": 90, "cycles": {"fir": 101}}, {"cycles": {"fir": 100}}))
    assert [(line.name, line.exceeded) for line in lines] == [("cycles.fir", True)]


def test_limit_itself_is_within_the_budget():
    (line,) = compare({"flash_bytes": 100}, {"flash_bytes": 100})
    assert not line.exceeded


def test_limit_without_a_measurement_is_an_error():
    with pytest.raises(KeyError, match=r"cycles\.gone"):
        list(compare({"cycles": {}}, {"cycles": {"gone": 1}}))


def test_budget_names_what_the_project_promises():
    limits = load_limits()
    assert {"hx711_read", "fir32_generic", "weight_kf_constant"} <= limits["cycles"].keys()
    assert limits["flash_bytes"] <= 30 * 1024
    assert limits["ram_static_bytes"] + limits["stack_worst_bytes"] <= 1.9 * 1024
    assert limits["stack_worst_bytes"] <= 350
    assert limits["cycles"]["scale"] <= 1500
    assert limits["cycles"]["zupt_gru"] <= 7500


def test_sections_are_read_from_avr_size():
    sections = parse_sections("section  size  addr\n.text  300  0\n.bss  12  8388864\nTotal 312\n")
    assert sections == {".text": 300, ".bss": 12}
    assert ".bss" not in FLASH_SECTIONS


@pytest.mark.parametrize(
    ("version", "held"), [("5.4.0", True), ("5.4", True), ("14.2.0", False), ("5.40", False)]
)
def test_limits_are_held_against_the_reference_compiler_alone(version, held):
    assert is_reference(version) is held

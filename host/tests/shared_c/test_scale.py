# SPDX-License-Identifier: MIT
"""scale.c: golden vectors, its exact twin on any input, and parity with the float64 model."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.tests.shared_c.scales import (
    RECIPROCALS,
    counts_q7_of,
    int32,
    lawful_configs,
    times_us,
    uint32,
)
from terazi.cshared import SCALE_UNITS, Scale, ScaleFlag, ScaleRefusedError, ScaleStatus
from terazi.cshared._cshared import ffi, lib
from terazi.design import scale as design
from terazi.models import exact_scale
from terazi.models import scale as model
from terazi.models.vectors import golden

USUAL = design.config()
COMMANDS = ("zero", "tare", "tare_clear", "show", "count_out", "interrupt")


def config_of(vector) -> dict:
    lists = ("point_counts_q7", "point_mass_mg")
    return {
        field: [int(word) for word in vector.parameters[field].split()]
        if field in lists
        else vector.parameter(field)
        for field in USUAL
    }


def command(scale: Scale, number: int, argument: int) -> int:
    """A vector's command; gives the status."""
    name = COMMANDS[number - 1]
    try:
        getattr(scale, name)(*([argument] if name in ("show", "count_out") else []))
    except ScaleRefusedError as refused:
        return refused.status
    return ScaleStatus.OK


@pytest.mark.parametrize("vector", golden("scale_"), ids=str)
def test_scale_reproduces_vector_bit_for_bit(vector):
    scale = Scale(config_of(vector))
    columns = ("command", "argument", "raw", "counts", "device_us", "answer")
    results = ("net_mg", "shown", "pieces", "mass_mg")
    for number, argument, raw, counts, us, answer, *wanted in zip(
        *(vector[name] for name in columns + results), strict=True
    ):
        if number:
            assert command(scale, number, argument) == answer
        else:
            assert scale.update(counts, us, raw) == answer
        assert [scale.net_mg, scale.shown, scale.pieces, scale.mass(counts)] == wanted
    for field in ("steps", "step_us", "step_from_mg", "step_to_mg", "kept_mg"):
        assert getattr(scale, field) == vector.parameter(f"final_{field}")


def test_scale_vectors_reach_every_flag_and_every_refusal_of_a_command():
    answers = [
        (number, answer)
        for vector in golden("scale_")
        for number, answer in zip(vector["command"], vector["answer"], strict=True)
    ]
    assert {flag for flag in ScaleFlag if any(not n and a & flag for n, a in answers)} == set(
        ScaleFlag
    )
    assert {status for number, status in answers if number} == {
        ScaleStatus.OK,
        ScaleStatus.NOT_STABLE,
        ScaleStatus.OUT_OF_RANGE,
        ScaleStatus.TOO_LIGHT,
        ScaleStatus.UNKNOWN,
    }


def test_scale_names_are_those_of_the_twin():
    assert {s.name: s.value for s in ScaleStatus} == {s.name: s.value for s in exact_scale.Status}
    assert {f.name: f.value for f in ScaleFlag} == {f.name: f.value for f in exact_scale.Flag}
    assert list(SCALE_UNITS) == [name.upper() for name in design.units()]


def test_scale_default_and_table_in_rom_are_those_of_the_spec():
    for field, value in USUAL.items():
        built = getattr(lib.scale_default, field)
        assert (list(built) if isinstance(value, list) else built) == value
    table = [lib.scale_unit_reciprocals[at] for at in range(lib.SCALE_UNIT_COUNT)]
    assert [(row[0] << 16 | row[1], row[2]) for row in table] == RECIPROCALS


samples = st.tuples(st.just(0), int32, int32, st.sampled_from((1, 12_500, 200_000, 1 << 31)))
small = st.tuples(st.just(0), st.integers(-3000, 3000), st.integers(-300, 300), st.just(12_500))
commands = st.tuples(st.integers(1, 6), st.integers(0, 3), st.just(0), st.just(0))


@given(
    config=lawful_configs(),
    rows=st.lists(st.one_of(samples, small, small, commands), min_size=1, max_size=60),
    start_us=uint32,
)
def test_scale_is_its_exact_twin_on_any_samples_and_commands(config, rows, start_us):
    scale, twin = Scale(config), exact_scale.Scale(config, RECIPROCALS)
    us, counts = start_us, 0
    for number, argument, change, elapsed_us in rows:
        if number:
            name = COMMANDS[number - 1]
            wanted = getattr(twin, name)(*([argument] if name in ("show", "count_out") else []))
            assert command(scale, number, argument) == (wanted or 0)
        else:
            us = (us + elapsed_us) % (1 << 32)
            counts = change if abs(change) > 300 else counts + change
            counts = max(min(counts, (1 << 31) - 1), -(1 << 31))
            if abs(argument) > 3000:
                raw = argument
            else:
                raw = max(min(counts + argument, (1 << 31) - 1), -(1 << 31))
            assert scale.update(counts, us, raw) == twin.update(counts, us, raw)
        assert (scale.net_mg, scale.shown, scale.pieces) == (twin.net_mg, twin.shown, twin.pieces)
        assert (scale.steps, scale.step_us) == (twin.steps, twin.step_us)
        assert (scale.rough_q4, scale.lag_q3) == (twin.rough_q4, twin.lag_q3)
        assert (scale.step_from_mg, scale.step_to_mg) == (twin.step_from_mg, twin.step_to_mg)


@given(config=lawful_configs(), data=st.data())
def test_scale_refuses_what_its_contract_refuses(config, data):
    field = data.draw(st.sampled_from(sorted(config)))
    if isinstance(config[field], list):
        changed = list(config[field])
        changed[data.draw(st.integers(0, 7))] = data.draw(int32)
    elif field.endswith("_us"):
        changed = data.draw(uint32)
    else:
        eight = field not in ("max_mg", "interval_mg", "under_mg", "step_mg", "stable_band_mg")
        changed = data.draw(st.integers(0, 255) if eight else int32)
    asked = config | {field: changed}
    wanted = exact_scale.judge(asked, RECIPROCALS)
    try:
        Scale(asked)
        answer = ScaleStatus.OK
    except ScaleRefusedError as refused:
        answer = refused.status
    assert answer == wanted


M, T = exact_scale.MAX_MAX, exact_scale.TIME_MAX_US
FAR = exact_scale.COUNTS_MAX


@pytest.mark.parametrize(
    ("status", "changed"),
    [
        (ScaleStatus.BAD_COUNT, {"points": 1}),
        (ScaleStatus.BAD_COUNT, {"points": 9}),
        (ScaleStatus.BAD_POINT, {"point_counts_q7": [0, FAR + 1, *[0] * 6]}),
        (ScaleStatus.BAD_POINT, {"point_counts_q7": [-FAR - 2, FAR, *[0] * 6]}),
        (ScaleStatus.BAD_POINT, {"point_mass_mg": [0, M + 1, *[0] * 6]}),
        (ScaleStatus.BAD_POINT, {"point_mass_mg": [-M - 1, M, *[0] * 6]}),
        (ScaleStatus.NOT_MONOTONE, {"point_counts_q7": [5, 5, *[0] * 6]}),
        (ScaleStatus.NOT_MONOTONE, {"point_mass_mg": [5, 5, *[0] * 6]}),
        (ScaleStatus.NOT_MONOTONE, {"point_mass_mg": [5, 4, *[0] * 6]}),
        (
            ScaleStatus.NOT_MONOTONE,
            {"points": 3, "point_counts_q7": [0, -90, -80, *[0] * 5],
             "point_mass_mg": [0, 9, 19, *[0] * 5]},
        ),
        (ScaleStatus.TOO_STEEP, {"point_counts_q7": [0, 5_000_000, *[0] * 6]}),
        (ScaleStatus.BAD_RANGE, {"max_mg": 0}),
        (ScaleStatus.BAD_RANGE, {"max_mg": M + 1}),
        (ScaleStatus.BAD_RANGE, {"interval_mg": 0}),
        (ScaleStatus.BAD_RANGE, {"interval_mg": 5_000_000 // 16 + 1}),
        (ScaleStatus.BAD_RANGE, {"under_mg": -1}),
        (ScaleStatus.BAD_RANGE, {"under_mg": 5_000_001}),
        (ScaleStatus.BAD_RANGE, {"step_mg": -1}),
        (ScaleStatus.BAD_RANGE, {"step_mg": 5_000_001}),
        (ScaleStatus.BAD_RANGE, {"stable_band_mg": -1}),
        (ScaleStatus.BAD_RANGE, {"stable_band_mg": 501}),
        (ScaleStatus.BAD_DIVISION, {"unit": lib.SCALE_UNIT_COUNT}),
        (ScaleStatus.BAD_DIVISION, {"decimals": 7}),
        (ScaleStatus.BAD_DIVISION, {"digit": 0}),
        (ScaleStatus.BAD_DIVISION, {"digit": 3}),
        (ScaleStatus.BAD_DIVISION, {"hysteresis_q8": 128}),
        (ScaleStatus.BAD_DIVISION, {"decimals": 4}),  # d of 0.1 mg
        (ScaleStatus.BAD_DIVISION, {"decimals": 2, "max_mg": 1 << 23}),
        (ScaleStatus.BAD_TIME, {"stable_us": 0}),
        (ScaleStatus.BAD_TIME, {"stable_us": T + 1}),
        (ScaleStatus.BAD_TIME, {"gap_us": 0}),
        (ScaleStatus.BAD_TIME, {"gap_us": T + 1}),
    ],
)  # fmt: skip
def test_scale_refuses_by_name_what_lies_one_beyond_its_contract(status, changed):
    assert exact_scale.judge(USUAL | changed, RECIPROCALS) == status
    with pytest.raises(ScaleRefusedError) as refused:
        Scale(USUAL | changed)
    assert refused.value.status == status


@pytest.mark.parametrize(
    "changed",
    [
        {"point_counts_q7": [-FAR - 1, FAR, *[0] * 6], "point_mass_mg": [-M, M - 2, *[0] * 6]},
        {"max_mg": M, "interval_mg": M // 16, "under_mg": M, "step_mg": M},
        {"max_mg": 16, "interval_mg": 1, "under_mg": 0, "step_mg": 0, "stable_band_mg": 0},
        {"decimals": 2, "max_mg": (1 << 23) - 1 - 9000},
        {"stable_band_mg": 500},
        {"stable_us": T, "gap_us": T, "hysteresis_q8": 127},
    ],
)
def test_scale_takes_what_lies_at_the_bounds_of_its_contract(changed):
    assert exact_scale.judge(USUAL | changed, RECIPROCALS) == ScaleStatus.OK
    Scale(USUAL | changed)


def test_scale_init_that_is_refused_changes_nothing():
    scale = Scale()
    scale.update(55_000_000, 12_500)
    before = scale.save()
    bad = ffi.new("scale_config_t *", USUAL | {"points": 9})
    assert lib.scale_init(scale._c, bad) == ScaleStatus.BAD_COUNT
    assert scale.save() == before


@given(config=lawful_configs(), first=int32, second=int32)
def test_scale_curve_never_falls_and_lies_within_its_budget(config, first, second):
    config = config | {"options": 0}
    sign = -1 if config["point_counts_q7"][1] < config["point_counts_q7"][0] else 1
    used = slice(0, config["points"])
    points = np.array(config["point_counts_q7"][used]) / design.ONE_COUNT_Q7
    points = list(zip(points, config["point_mass_mg"][used], strict=True))
    scale = Scale(config)
    counts = [sign * max(each, 1 - (1 << 31)) for each in sorted((first, second))]
    masses = scale.masses(counts)
    truth = model.mass_mg(np.array(counts) / design.ONE_COUNT_Q7, points)
    assert np.abs(masses - truth).max() <= model.MASS_BUDGET_MG + 1e-6
    assert masses[0] <= masses[1]


@given(config=lawful_configs(), counts=int32, other=int32)
def test_scale_mass_is_what_an_update_takes_and_changes_nothing(config, counts, other):
    scale = Scale(config)
    scale.update(other, 1)
    before = scale.save()
    mass_mg = scale.mass(counts)
    assert scale.save() == before
    assert mass_mg == exact_scale.Scale(config, RECIPROCALS).mass(counts)
    scale.update(counts, 2)
    assert scale.mass_mg == mass_mg


@given(config=lawful_configs())
def test_scale_curve_meets_every_point_of_the_calibration(config):
    for at in range(config["points"]):
        off = config["point_mass_mg"][at] - Scale(config).mass(config["point_counts_q7"][at])
        assert 0 <= off <= (1 if at == config["points"] - 1 else 0)


def phases(seed):
    """Loads that stand, swing and go, in counts: estimates, measurements; times not quite even."""
    rng = np.random.default_rng(seed)
    loads = [0.3 * rng.standard_normal()]
    loads += [*rng.uniform(-15, 5200, 6), 0.1, 0.1]
    grams = np.concatenate([np.full(rng.integers(50, 120), each) for each in loads])
    grams += 0.01 * rng.standard_normal(len(grams))
    grams[130:150] += 40 * np.sin(np.arange(20))
    raw = grams + 0.09 * rng.standard_normal(len(grams))
    us = np.cumsum(rng.integers(11_000, 13_500, len(grams)))
    return counts_q7_of(grams), counts_q7_of(raw), us


def model_of(counts, raw, us):
    return model.scale(
        counts / design.ONE_COUNT_Q7, us * 1e-6, USUAL, raw=raw / design.ONE_COUNT_Q7
    )


@pytest.mark.parametrize("seed", range(16))
def test_scale_is_the_model_but_for_its_budget(seed):
    """Where the model's decisions are clear of their limits the flags are the same throughout;
    elsewhere they differ for the one sample that falls the other way."""
    counts, raw, us = phases(seed)
    scale = Scale()
    loads, flags = [], []
    for each, measured, now in zip(counts.tolist(), raw.tolist(), us.tolist(), strict=True):
        flags.append(int(scale.update(each, now, measured)))
        loads.append(scale.load_mg)
    truth = model_of(counts, raw, us)
    clear = truth.margin_mg > 2 * model.LOAD_BUDGET_MG
    same = np.array(flags) == truth.flags
    assert same.all() if clear else same.mean() > 0.97
    if same.all():
        assert np.abs(np.array(loads) - truth.load_mg).max() <= model.LOAD_BUDGET_MG
        assert scale.steps == len(truth.steps)
        left_s, from_mg, to_mg = truth.steps[-1]
        assert scale.step_us == round(left_s * 1e6)
        assert abs(scale.step_from_mg - from_mg) <= model.LOAD_BUDGET_MG
        assert abs(scale.step_to_mg - to_mg) <= model.LOAD_BUDGET_MG


def test_scale_parity_is_looked_at_where_decisions_are_clear_or_fall_alike():
    same = []
    for seed in range(16):
        counts, raw, us = phases(seed)
        flags, *_ = Scale().block(counts, us, raw)
        same.append(bool((flags == model_of(counts, raw, us).flags).all()))
    assert sum(same) >= 8


@given(config=lawful_configs(), cut=st.integers(0, 79), seed=st.integers(0, 9))
def test_scale_saved_restored_or_copied_continues_identically(config, cut, seed):
    rng = np.random.default_rng(seed)
    counts = rng.integers(-(2**24), 2**24, 80) * (rng.random(80) < 0.2)
    us = times_us(80, start_us=(1 << 32) - 500_000)
    scale = Scale(config)
    scale.block(counts[:cut], us[:cut])
    copy, restored = scale.copy(), Scale(config)
    restored.restore(scale.save())
    expected = [each.tolist() for each in scale.block(counts[cut:], us[cut:])]
    for other in (copy, restored):
        assert [each.tolist() for each in other.block(counts[cut:], us[cut:])] == expected


def test_scale_refuses_what_no_scale_can_take():
    with pytest.raises(ValueError, match="configuration of the scale"):
        Scale(USUAL | {"points": 256})
    with pytest.raises(ScaleRefusedError, match="configuration: not monotone"):
        Scale(design.config([(0.0, 0.0), (9e5, 2000.0), (8e5, 3000.0)]))
    with pytest.raises(ValueError, match="no unit 'stone'"):
        design.config(unit="stone")
    with pytest.raises(ValueError, match="has no weight"):
        design.config(weight=1)
    with pytest.raises(ValueError, match="refuses this configuration: BAD_COUNT"):
        exact_scale.Scale(USUAL | {"points": 1}, RECIPROCALS)
    scale = Scale()
    with pytest.raises(ValueError, match="2 counts and 1 times"):
        scale.block([1, 2], [3])
    with pytest.raises(TypeError, match="row of integers"):
        scale.block([0.5], [3])
    with pytest.raises(ValueError, match="do not fit in uint32"):
        scale.block([1], [-1])
    with pytest.raises(ValueError, match="not the state"):
        scale.restore(b"")
    with pytest.raises(AttributeError):
        _ = scale._unknown

# SPDX-License-Identifier: MIT
"""Replay agrees with what is right and finds what is wrong, whatever was lost on the way."""

import dataclasses

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from host.tests.captures import CaptureMaker
from terazi.errors import CannotRead
from terazi.link.generated.messages import ChainOrder, KfKind
from terazi.recorder import load_recording
from terazi.replay import replay

TAPS = 32


@pytest.fixture
def maker(tmp_path):
    return CaptureMaker(tmp_path / "one.terazi", kf_kind=KfKind.CONSTANT)


def replayed(path):
    result = replay(load_recording(path))
    return result, {stage.stage: stage for stage in result.stages}


def off_by_one(field, at):
    def change(index, sample):
        if index != at:
            return sample
        return dataclasses.replace(sample, **{field: getattr(sample, field) + 1})

    return change


def test_replay_of_an_undisturbed_recording_is_bit_identical_and_complete(maker):
    result, stages = replayed(maker.hello().samples(700).end())
    assert result.agrees
    assert [stage.compared for stage in stages.values()] == [700, 700, 700]
    assert [model.compared for model in result.models] == [700, 700, 700]
    assert all(0 < model.largest <= model.budget for model in result.models)


@pytest.mark.parametrize(
    ("field", "stage"), [("fir_counts", "fir"), ("kf_counts_q7", "kalman"), ("mass_mg", "mass")]
)
def test_replay_finds_a_single_wrong_bit_and_says_where(maker, field, stage):
    result, stages = replayed(maker.hello().samples(300, change=off_by_one(field, 200)).end())
    assert not result.agrees
    assert not result.is_bit_identical
    assert stages[stage].first[0].sample == 200
    assert stages[stage].first[0].conversion == 201
    assert stages[stage].first[0].device == stages[stage].first[0].host + 1


def test_replay_shows_the_first_differences_only(maker):
    path = maker.hello().samples(
        100, change=lambda i, s: dataclasses.replace(s, fir_counts=s.fir_counts + 1)
    )
    _result, stages = replayed(path.end())
    assert stages["fir"].differing == 100
    assert [one.sample for one in stages["fir"].first] == [0, 1, 2, 3, 4]


def test_replay_finds_what_lies_beyond_the_models_budget(maker):
    """The C agrees with itself; only the raw counts that the models saw are others."""
    path = maker.hello().samples(300, change=off_by_one("mass_mg", 5)).end()
    result, _stages = replayed(path)
    assert {model.stage: model.beyond for model in result.models} == {
        "fir": 0,
        "fir and kalman": 0,
        "mass": 1,
    }


@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(lost=st.sets(st.integers(0, 599), max_size=30))
def test_replay_agrees_whatever_frames_are_lost(tmp_path, lost):
    path = tmp_path / "lossy.terazi"
    path.unlink(missing_ok=True)
    maker = CaptureMaker(path)
    result, stages = replayed(maker.hello().samples(600, drop=lambda i: i in lost).end())
    assert result.agrees
    assert result.samples == 600 - len(lost)
    assert stages["fir"].compared <= result.samples


def test_replay_of_a_stream_joined_late_begins_when_the_window_is_full(maker):
    maker.samples(300, drop=lambda index: True)
    result, stages = replayed(maker.hello().samples(400).end())
    assert result.agrees
    assert result.unprimed == 1
    assert stages["fir"].compared == 400 - (TAPS - 1)
    assert 300 < stages["kalman"].compared < 400
    assert {model.stage: model.compared for model in result.models} == {
        "fir": 0,
        "fir and kalman": 0,
        "mass": 400,
    }


def test_replay_of_a_stream_joined_late_still_finds_a_wrong_bit(maker):
    maker.samples(300, drop=lambda index: True)
    path = maker.hello().samples(400, change=off_by_one("kf_counts_q7", 350)).end()
    _result, stages = replayed(path)
    assert stages["kalman"].first[0].sample == 350


def test_replay_runs_on_over_conversions_that_the_device_lost(maker):
    maker.hello().samples(100)
    result, stages = replayed(maker.samples(200, skip=3).end())
    assert result.agrees
    assert stages["kalman"].compared == 300
    assert len(result.segments) == 1


def test_replay_starts_anew_where_the_filters_did(maker):
    result, stages = replayed(maker.hello().samples(100).samples(200, restart=True).end())
    assert result.agrees
    assert len(result.segments) == 2
    assert stages["kalman"].compared == 300


BENT = [(1000.0, 0.0), (200_000.0, 480.0), (900_000.0, 2000.0)]


def test_replay_follows_a_calibration_from_its_end_on(maker):
    maker.hello().samples(100).calibrated(BENT).samples(100)
    result, stages = replayed(maker.tare().samples(100).end())
    assert result.agrees
    assert stages["mass"].compared == 300


def test_replay_finds_a_mass_of_the_old_calibration_under_the_new_one(maker):
    maker.hello().samples(100).calibrated(BENT)
    path = maker.samples(100, change=off_by_one("mass_mg", 60)).end()
    _result, stages = replayed(path)
    assert [one.sample for one in stages["mass"].first] == [160]


def test_replay_does_not_judge_masses_by_a_calibration_that_was_not_told(maker):
    maker.hello().samples(100).calibrated(BENT, told=False)
    result, stages = replayed(maker.samples(30).end())
    assert result.agrees
    assert stages["mass"].compared == 100
    assert stages["kalman"].compared == 130


def test_replay_does_not_judge_masses_after_an_ack_that_may_have_been_a_calibrations_end(maker):
    maker.hello().samples(100).tare(lose_ack=True).samples(50)
    result, stages = replayed(maker.hello().samples(30).end())
    assert result.agrees
    assert stages["mass"].compared == 180, "told again: known back to the loss"


def test_replay_names_filters_that_this_host_does_not_know(maker):
    maker.say(dataclasses.replace(maker.chain.hello(), fir_design=200))
    with pytest.raises(CannotRead, match="FIR design 200"):
        replay(load_recording(maker.samples(10).end()))


def test_replay_wants_samples(maker):
    with pytest.raises(CannotRead, match="holds no samples"):
        load_recording(maker.hello().end())


def test_replay_wants_to_know_who_spoke(maker):
    with pytest.raises(CannotRead, match="holds no HELLO"):
        load_recording(maker.samples(10).end())


@pytest.mark.parametrize("order", ChainOrder)
@pytest.mark.parametrize("kf_kind", KfKind)
def test_replay_follows_the_order_and_the_filter_that_were_announced(maker, order, kf_kind):
    maker.hello().samples(200).another_chain(order, kf_kind)
    maker.samples(500, restart=True).tare().samples(300)
    result, stages = replayed(maker.end())
    assert result.agrees
    assert [stage.compared for stage in stages.values()] == [1000, 1000, 1000]
    assert result.chains[0] == "fir_kf, constant"
    assert result.chains[-1] == f"{order.name.lower()}, {kf_kind.name.lower()}"
    assert sum(model.compared for model in result.models) >= 3000


@pytest.mark.parametrize("order", ChainOrder)
@pytest.mark.parametrize("kf_kind", KfKind)
@pytest.mark.parametrize(
    ("field", "stage"), [("fir_counts", "fir"), ("kf_counts_q7", "kalman"), ("mass_mg", "mass")]
)
def test_replay_finds_a_wrong_bit_in_every_chain(maker, order, kf_kind, field, stage):
    maker.hello().another_chain(order, kf_kind).samples(300, change=off_by_one(field, 200))
    result, stages = replayed(maker.end())
    assert not result.is_bit_identical
    assert stages[stage].first[0].sample == 200

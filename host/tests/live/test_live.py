# SPDX-License-Identifier: MIT
"""The live screen against a fake device: what it shows, and what its keys do."""

import asyncio
import time
from contextlib import contextmanager
from dataclasses import replace
from itertools import groupby

import pytest

from host.tests.fake_chain import EMPTY_COUNTS, Chain
from host.tests.fake_device import FakeDevice
from host.tests.fake_imu import FakeImu
from terazi.link import open_link
from terazi.link.generated.messages import (
    AttitudeFlag,
    FaultFlag,
    StreamFlag,
    Tare,
    Weight,
)
from terazi.live import parts
from terazi.live.app import LiveApp
from terazi.live.session import Session
from terazi.recorder.recording import load_recording

WAIT_S = 20.0
LOADED_S = 3.0  # from then on something lies on the scale
SIZE = (80, 24)


@contextmanager
def live(path):
    """A fake device and a session that follows it."""
    load = {"load": lambda t_s: EMPTY_COUNTS + (60_000 if t_s > LOADED_S else 0), "imu": FakeImu}
    with FakeDevice(speed=5.0, **load) as device, open_link(device.path, None) as link:
        link.hello()
        with Session(link, record_to=lambda: path) as session:
            yield device, session


def wait_for(found, why: str) -> None:
    end_s = time.monotonic() + WAIT_S
    while not found():
        assert time.monotonic() < end_s, why
        time.sleep(0.02)


def rests_above(session: Session, net_mg: int) -> bool:
    balance = session.watch.balance
    return balance.is_stable and balance.weight.net_mg > net_mg


def screen_text(app: LiveApp) -> str:
    """What stands on the screen, as lines of text."""
    strips = app.screen._compositor.render_strips()
    return "\n".join("".join(segment.text for segment in strip) for strip in strips)


def test_weight_attitude_and_health_are_shown_on_80_by_24(tmp_path):
    async def look() -> str:
        app = LiveApp(session)
        async with app.run_test(size=SIZE) as pilot:
            await pilot.pause(0.3)
            return screen_text(app)

    with live(tmp_path / "a.terazi") as (_device, session):
        wait_for(lambda: session.watch.balance.weight and session.attitude, "nothing came")
        wait_for(lambda: session.watch.status, "no STATUS came")
        shown = asyncio.run(look())
    assert all(len(line) <= SIZE[0] for line in shown.splitlines())
    for words in ("roll", "pitch", "yaw", "SPS", "0 frames lost", "tare", "record", "faults"):
        assert words in shown


def test_keys_tare_and_switch_to_text_lines_and_back(tmp_path):
    async def press(keys: str) -> None:
        app = LiveApp(session)
        async with app.run_test(size=SIZE) as pilot:
            for key in keys:
                await pilot.press(key)
                await pilot.pause(0.1)

    with live(tmp_path / "a.terazi") as (device, session):
        wait_for(lambda: rests_above(session, 100_000), "never stable")
        asyncio.run(press("t"))
        wait_for(lambda: Tare.ID in device.commands, "no TARE was sent")
        wait_for(lambda: session.said[0] == "tare: done", "the tare was never done")
        asyncio.run(press("x"))
        wait_for(lambda: session.is_text, "no text mode")
        asyncio.run(press("x"))
        wait_for(lambda: not session.is_text, "no frames again")
        assert [on for on, _again in groupby(device.chain.text_modes)] == [1, 0]


def test_text_lines_come_where_samples_are_streamed(tmp_path):
    with live(tmp_path / "a.terazi") as (device, session):
        wait_for(lambda: session.watch.balance.weight, "nothing came")
        assert not device.chain.mask & StreamFlag.SAMPLE
        session.order("text")
        wait_for(lambda: session.is_text and session.said[0], "no text mode")
        assert device.chain.mask & StreamFlag.SAMPLE  # a line stands for a SAMPLE
        assert "text mode" in parts.angles(session).plain
        session.order("text")
        wait_for(lambda: session.said[0] == "text: frames again", "no frames again")
        assert not device.chain.mask & StreamFlag.SAMPLE


def test_the_newest_events_stand_on_80_by_24(tmp_path):
    async def look() -> str:
        app = LiveApp(session)
        async with app.run_test(size=SIZE) as pilot:
            session.watch.events.extend(f"event {number} " + 90 * "." for number in range(6))
            session.said = ("word " * 20, True)
            await pilot.pause(0.5)
            return screen_text(app)

    with live(tmp_path / "a.terazi") as (_device, session):
        wait_for(lambda: session.watch.events, "the load makes no step")
        shown = asyncio.run(look())
    assert "event 5" in shown
    assert "event 4" in shown
    assert shown.count("word") == 20  # a long answer takes two lines


def test_no_weight_is_shown_while_a_fault_spoils_it(tmp_path):
    with live(tmp_path / "a.terazi") as (_device, session):
        wait_for(lambda: session.watch.balance.weight, "nothing came")
        weight = session.watch.balance.weight
        session.watch.balance.weight = replace(weight, faults=FaultFlag.CABLE_OUT)
        digits, words = parts.weight_digits(session), parts.weight_words(session).plain
    assert digits.startswith("-----")
    assert words == "no weight to be trusted: cable out"


def test_attitudes_give_way_where_they_leave_no_room_for_the_weight(tmp_path, monkeypatch):
    def wants(chain, message):
        is_starved = isinstance(message, Weight) and chain.mask & StreamFlag.ATTITUDE
        return not is_starved and told(chain, message)

    told = Chain.wants
    monkeypatch.setattr(Chain, "wants", wants)
    with live(tmp_path / "a.terazi") as (_device, session):
        wait_for(lambda: session.watch.balance.weight, "attitudes keep the weight out")
        assert session.is_narrow
        assert session.said[1]
        wait_for(lambda: "no room" in parts.angles(session).plain, "why there is none is not told")
        assert session.attitude_rate_hz == 0


def test_what_happens_for_one_attitude_is_shown_long_enough_to_be_seen(tmp_path):
    with live(tmp_path / "a.terazi") as (_device, session):
        wait_for(lambda: session.attitude, "nothing came")
        assert session.attitude_flags & AttitudeFlag.RESTARTED  # told by the first one alone
        wait_for(lambda: not session.attitude_flags & AttitudeFlag.RESTARTED, "it stays for ever")


def test_a_recording_is_begun_and_ended_by_its_key_and_can_be_read(tmp_path):
    path = tmp_path / "walk.terazi"
    with live(path) as (_device, session):
        session.order("record")
        wait_for(lambda: session.said[0].startswith("record: into"), "no recording began")
        wait_for(lambda: session.recorder and session.recorder.samples > 20, "nothing recorded")
        session.order("record")
        wait_for(lambda: session.recorder is None, "it did not end")
    assert "samples in" in session.said[0]
    assert session.recorded == [session.said[0].removeprefix("record: ")]
    assert load_recording(path)
    assert path.with_suffix(".csv").is_file()


def test_a_recording_that_cannot_be_written_says_so_and_the_screen_goes_on(tmp_path):
    path = tmp_path / "a.terazi"
    path.write_text("older")
    with live(path) as (_device, session):
        session.order("record")
        wait_for(lambda: session.said[1], "no complaint")
        assert str(path) in session.said[0]
        before = session.watch.balance.weight
        wait_for(lambda: session.watch.balance.weight is not before, "it stands still")
        assert session.recorder is None


def test_a_port_that_vanishes_ends_the_screen_and_is_told():
    async def run() -> int | None:
        app = LiveApp(session)
        async with app.run_test(size=SIZE) as pilot:
            for _turn in range(200):
                if app.return_code is not None:
                    break
                await pilot.pause(0.1)
        return app.return_code

    with FakeDevice(speed=20.0, vanish_after=200) as device, open_link(device.path, None) as link:
        link.hello()
        with Session(link) as session:
            assert asyncio.run(run()) == 1
    assert session.fault is not None


@pytest.mark.parametrize("key", ["f", "escape"])
def test_the_list_of_faults_opens_and_closes(tmp_path, key):
    async def look() -> tuple[str, str]:
        app = LiveApp(session)
        async with app.run_test(size=SIZE) as pilot:
            await pilot.press("f")
            await pilot.pause(0.2)
            opened = screen_text(app)
            await pilot.press(key)
            await pilot.pause(0.2)
            return opened, screen_text(app)

    with live(tmp_path / "a.terazi") as (_device, session):
        opened, closed = asyncio.run(look())
    assert "No fault holds." in opened
    assert "No fault holds." not in closed


def test_bubble_stands_where_the_board_is_high():
    rows = parts.bubble(_Tilted((0.9990482, 0.0, -0.0436194, 0.0))).plain.splitlines()  # -5 deg
    middle = rows[parts.BUBBLE_HEIGHT // 2]
    assert middle.index("●") == parts.BUBBLE_WIDTH // 2 + 5


class _Tilted:
    """A session that has one ATTITUDE."""

    def __init__(self, quat) -> None:
        from types import SimpleNamespace

        names = ("quat_w_q30", "quat_x_q30", "quat_y_q30", "quat_z_q30")
        told = {name: round(part * (1 << 30)) for name, part in zip(names, quat, strict=True)}
        self.attitude = SimpleNamespace(message=SimpleNamespace(**told))
        self.has_attitude = True

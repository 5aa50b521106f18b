# SPDX-License-Identifier: MIT
"""Golden vectors of settings, from its twin."""

from __future__ import annotations

import random
from collections.abc import Iterator

from terazi.models import settings as twin
from terazi.models.settings import Entry, Reading
from tools.gen import messages_spec, settings_spec
from tools.gen.golden import SEED, Draft
from tools.gen.spec import load

ORIGIN = "terazi.models.settings, the contract of the header"


def entries() -> list[Entry]:
    """The keys of settings.toml as the twin wants them."""
    found = settings_spec.parse(load("settings"), messages_spec.parse(load("messages")))
    return [Entry.of(one) for one in found.settings]


def _values(rng: random.Random, keys: list[Entry]) -> list[int]:
    return [rng.randint(entry.minimum, entry.maximum) for entry in keys]


def _slots(rng: random.Random, keys: list[Entry]) -> Iterator[bytes]:
    """Slots with all that may stand there, each followed by nothing."""
    some = _values(rng, keys)
    whole = twin.record(keys, some, 65535)
    yield whole
    for extreme in ("minimum", "maximum"):
        yield twin.record(keys, [getattr(entry, extreme) for entry in keys], 0)
    body = twin.payload(keys, some)
    for known in (0, 1, 2, 7, 12, 40, len(keys) - 1):  # of older firmware
        yield twin.frame(twin.payload(keys[:known], some[:known]), 7)
    yield twin.frame(body + b"\x01", 8)  # of newer firmware
    yield twin.frame(body.ljust(249, b"\xa5"), 9)
    yield twin.frame(body, 10, version=2)
    yield twin.frame(body, 11, version=0)
    for bit in rng.sample(range(8, 8 * len(whole)), 24):  # one bit has changed, the magic apart
        spoilt = bytearray(whole)
        spoilt[bit // 8] ^= 1 << bit % 8
        yield bytes(spoilt)
    for length in (250, 255):  # longer than a slot
        yield bytes([twin.MAGIC, twin.VERSION, length]) + bytes(range(1, 250))
    yield bytes([twin.ERASED])
    yield bytes([0]) + whole[1:]
    yield bytes([twin.ERASED]) + whole[1:]
    yield bytes([twin.MAGIC])
    yield whole[:100]


def _records(keys: list[Entry]) -> Draft:
    rows = []
    for slot in _slots(random.Random(SEED + 50), keys):
        full = slot.ljust(twin.SLOT_LEN, bytes([twin.ERASED]))
        reading, sequence, values = twin.read(keys, full)
        held = b"" if values is None else twin.payload(keys, values)[: slot[2]]
        rows.append((full, int(reading), sequence, held))
    return Draft(
        "settings_records",
        "settings: what a slot holds, and which values",
        {
            "slot_hex": "256 bytes",
            "reading": "settings_reading_t",
            "sequence": "of a whole or a foreign record, else 0",
            "values_hex": "that a whole record holds, of the first keys; the others keep theirs",
        },
        rows,
        origin=ORIGIN,
        seed=str(SEED + 50),
    )


def _keys(keys: list[Entry]) -> Draft:
    rng, rows, values = random.Random(SEED + 51), [], twin.factory(keys)
    for key, entry in enumerate([*keys, Entry("u8", 0, 1, 0, False)]):
        asked = [entry.minimum, entry.maximum, rng.randint(entry.minimum, entry.maximum)]
        asked += [entry.minimum - 1, entry.maximum + 1, -(1 << 31), (1 << 31) - 1]
        for value in asked:
            if not -(1 << 31) <= value < 1 << 31:
                continue
            rows.append((key, value, int(twin.put(keys, values, key, value))))
    rows.append((255, 0, int(twin.Status.UNKNOWN_KEY)))
    return Draft(
        "settings_keys",
        "settings: what is taken by key",
        {
            "key": "u8",
            "asked": "int32",
            "status": "settings_status_t",
        },
        rows,
        origin=ORIGIN,
        seed=str(SEED + 51),
    )


def _choices() -> Draft:
    rng, rows = random.Random(SEED + 52), []
    none, rotten, foreign, whole = (
        Reading.NO_RECORD,
        Reading.ROTTEN,
        Reading.FOREIGN,
        Reading.WHOLE,
    )
    cases = [
        [(none, 0)] * 4,
        [(whole, 1), (none, 0), (none, 0), (none, 0)],
        [(whole, 5), (whole, 6), (whole, 3), (whole, 4)],
        [(whole, 65535), (whole, 1), (whole, 65533), (whole, 65534)],
        [(rotten, 0)] * 4,
        [(whole, 5), (rotten, 0), (whole, 3), (whole, 4)],
        [(whole, 5), (foreign, 6), (none, 0), (whole, 4)],
        [(foreign, 5), (whole, 6), (none, 0), (foreign, 4)],
    ]
    for _ in range(40):
        first = rng.randrange(1 << 16)
        case = [(rng.choice([*Reading][1:]), (first + rng.randrange(8)) % 65536) for _ in range(4)]
        cases.append([(r, s if r in (foreign, whole) else 0) for r, s in case])
    for case in cases:
        choice = twin.choose(case)
        flat = [number for pair in case for number in pair]
        rows.append((*map(int, flat), choice.reading, choice.slot, choice.rotten, choice.sequence))
    columns = {}
    for slot in range(twin.SLOTS):
        columns |= {f"reading_{slot}": "settings_reading_t", f"sequence_{slot}": "u16"}
    columns |= {
        "reading": "settings_reading_t of the choice",
        "slot": "where it stands",
        "rotten": "slots",
        "sequence": "u16",
    }
    rows = [tuple(int(number) for number in row) for row in rows]
    return Draft(
        "settings_choices",
        "settings: which of four slots counts",
        columns,
        rows,
        origin=ORIGIN,
        seed=str(SEED + 52),
    )


def drafts() -> Iterator[Draft]:
    """All of settings'."""
    keys = entries()
    yield from (_records(keys), _keys(keys), _choices())

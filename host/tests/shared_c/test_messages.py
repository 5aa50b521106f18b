# SPDX-License-Identifier: MIT
"""messages.c and the dataclasses over it: packed as the specification says."""

import dataclasses
import struct
from enum import IntEnum, IntFlag

import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.cshared import WIRE_FINGERPRINT, pack_message, unpack_message
from terazi.cshared._cshared import ffi, lib
from terazi.link.generated import messages
from tools.gen import messages_spec
from tools.gen.messages_py import class_name
from tools.gen.spec import load

WIRE = messages_spec.parse(load("messages"))
STRUCT_CODES = {"u8": "B", "u16": "H", "u32": "I", "i16": "h", "i32": "i"}


def class_of(message):
    return getattr(messages, class_name(message.name))


def layout(message) -> str:
    """The payload's layout for struct, an oracle that knows nothing of the C."""
    return "<" + "".join(STRUCT_CODES[field.type] for field in message.fields)


def values_of(message, *, in_range: bool):
    """Strategy of one tuple of field values."""
    limits = [
        field.range if in_range and field.range else field.type_range for field in message.fields
    ]
    return st.tuples(*(st.integers(low, high) for low, high in limits))


@pytest.mark.parametrize("message", WIRE.messages, ids=lambda message: message.name)
@given(data=st.data())
def test_message_survives_the_round_trip_and_lies_on_the_wire_as_specified(message, data):
    values = data.draw(values_of(message, in_range=True))
    made = class_of(message)(*values)
    payload = made.pack()
    assert payload == struct.pack(layout(message), *values)
    assert len(payload) == class_of(message).LEN == message.len_bytes
    assert class_of(message).unpack(payload) == made


@pytest.mark.parametrize(
    "message", [each for each in WIRE.messages if each.fields], ids=lambda message: message.name
)
@pytest.mark.parametrize("off_by", [-1, 1])
def test_message_of_another_length_is_refused_by_the_c_itself(message, off_by):
    held = ffi.new("uint8_t[]", message.len_bytes + 1)
    into = ffi.new(f"messages_{message.name}_t *")
    unpack = getattr(lib, f"messages_{message.name}_unpack")
    assert not unpack(into, held, message.len_bytes + off_by)


@pytest.mark.parametrize("message", WIRE.messages, ids=lambda message: message.name)
@given(payload=st.binary(max_size=60))
def test_message_of_any_bytes_is_read_or_refused(message, payload):
    fits = len(payload) == message.len_bytes
    if fits:
        values = struct.unpack(layout(message), payload)
        fits = all(
            field.range is None or field.range[0] <= value <= field.range[1]
            for field, value in zip(message.fields, values, strict=True)
        )
    if not fits:
        with pytest.raises(ValueError, match=message.name):
            class_of(message).unpack(payload)
    else:
        assert class_of(message).unpack(payload).pack() == payload


@pytest.mark.parametrize(
    ("name", "field", "limits"),
    [
        (message.name, field.name, field.range)
        for message in WIRE.messages
        for field in message.fields
        if field.range
    ],
)
def test_message_field_outside_its_range_is_refused_at_the_very_edge(name, field, limits):
    (message,) = (each for each in WIRE.messages if each.name == name)
    fields = {each.name: 0 for each in message.fields}
    lowest, highest = next(each for each in message.fields if each.name == field).type_range
    for edge in limits:
        assert unpack_message(name, pack_message(name, fields | {field: edge}))[field] == edge
    for outside in (limits[0] - 1, limits[1] + 1):
        if lowest <= outside <= highest:
            with pytest.raises(ValueError, match=f"{name}: a field is out of range"):
                unpack_message(name, pack_message(name, fields | {field: outside}))


def test_message_that_does_not_fit_its_types_is_refused():
    with pytest.raises(ValueError, match="ack"):
        messages.Ack(256, 0, 0).pack()
    with pytest.raises(ValueError, match="sample"):
        messages.Sample(0, 2**31, 0, 0, 0, 0, messages.SampleFlag(0), messages.WeightFlag(0)).pack()


def test_fingerprint_is_one_in_c_python_and_specification():
    assert WIRE_FINGERPRINT == messages.FINGERPRINT == WIRE.fingerprint


def test_fingerprint_moves_with_the_layout_and_not_with_the_words():
    def of(changed):
        text = messages_spec.canonical_text(changed, WIRE.groups)
        return messages_spec.crc16_mcrf4xx(text.encode())

    first, *rest = WIRE.messages
    assert of(WIRE.messages) == WIRE.fingerprint
    assert of((dataclasses.replace(first, summary="other words"), *rest)) == WIRE.fingerprint
    field = dataclasses.replace(first.fields[0], type="u32")
    for changed in (
        dataclasses.replace(first, id=0x77),
        dataclasses.replace(first, name="hallo"),
        dataclasses.replace(first, fields=first.fields[::-1]),
        dataclasses.replace(first, fields=(field, *first.fields[1:])),
        dataclasses.replace(first, fields=first.fields[1:]),
    ):
        assert of((changed, *rest)) != WIRE.fingerprint


def test_every_message_and_value_of_the_specification_has_its_python_name():
    assert sorted(messages.MESSAGES_BY_ID) == sorted(message.id for message in WIRE.messages)
    for group in WIRE.groups:
        kind = getattr(messages, class_name(group.name))
        assert issubclass(kind, IntFlag if group.is_flags else IntEnum)
        expected = {choice.name.upper(): choice.value for choice in group.choices}
        assert {each.name: each.value for each in kind} == expected


def test_unknown_enumerator_of_a_newer_device_stays_a_number():
    ack = messages.Ack.unpack(bytes([0x41, 7, 99]))
    assert ack.result == 99
    assert not isinstance(ack.result, messages.Result)
    assert isinstance(messages.Ack.unpack(bytes([0x41, 7, 4])).result, messages.Result)

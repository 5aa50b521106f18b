# SPDX-License-Identifier: MIT
"""messages of shared_c: the payloads' fields by name. terazi.link.generated stands on this."""

from __future__ import annotations

from collections.abc import Mapping

from terazi.cshared._cshared import ffi, lib

WIRE_FINGERPRINT = lib.MESSAGES_FINGERPRINT
"""Of the messages.toml that this C was generated from."""


def pack_message(name: str, fields: Mapping[str, int]) -> bytes:
    """Payload of the message `name`; ValueError where a field does not fit its type."""
    length = getattr(lib, f"MESSAGES_{name.upper()}_LEN")
    if length == 0:
        return b""
    try:
        message = ffi.new(f"messages_{name}_t *", dict(fields))
    except OverflowError as error:
        raise ValueError(f"{name}: {error}") from None
    payload = ffi.new("uint8_t[]", length)
    getattr(lib, f"messages_{name}_pack")(payload, message)
    return bytes(ffi.buffer(payload))


def unpack_message(name: str, payload: bytes) -> dict[str, int]:
    """Fields of the message `name`; ValueError where the C refuses the payload."""
    length = getattr(lib, f"MESSAGES_{name.upper()}_LEN")
    if len(payload) != length:
        raise ValueError(f"{name}: {len(payload)} bytes of payload, {length} expected")
    if length == 0:
        return {}
    message = ffi.new(f"messages_{name}_t *")
    held = ffi.from_buffer("uint8_t[]", payload)
    if not getattr(lib, f"messages_{name}_unpack")(message, held, length):
        raise ValueError(f"{name}: a field is out of range in {bytes(payload).hex()}")
    return {field: getattr(message, field) for field, _ in ffi.typeof(message).item.fields}

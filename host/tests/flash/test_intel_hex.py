# SPDX-License-Identifier: MIT
"""What counts as an image for the Uno, and what is refused before a board is touched."""

import random
import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.errors import CannotRead, FlashFailed
from terazi.link.intel_hex import APPLICATION_BYTES, read_image

END = ":00000001FF\n"


def record(kind: int, address: int, data: bytes) -> str:
    head = bytes((len(data), address >> 8, address & 0xFF, kind)) + data
    return ":" + (head + bytes((-sum(head) % 256,))).hex().upper() + "\n"


def hex_text(data: bytes, *, start: int = 0, step: int = 16) -> str:
    rows = range(0, len(data), step)
    return "".join(record(0, start + at, data[at : at + step]) for at in rows) + END


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "image.hex"
    path.write_text(text, encoding="ascii")
    return path


@pytest.mark.parametrize("size", [1, 16, 17, 4096, APPLICATION_BYTES])
def test_image_that_objcopy_writes_is_read(tmp_path, size):
    objcopy = shutil.which("avr-objcopy") or shutil.which("objcopy")
    if objcopy is None:
        pytest.skip("no objcopy on PATH to write the file")
    data = random.Random(size).randbytes(size)
    (tmp_path / "image.bin").write_bytes(data)
    path = tmp_path / "image.hex"
    command = [objcopy, "-I", "binary", "-O", "ihex", tmp_path / "image.bin", path]
    subprocess.run(command, check=True)
    assert read_image(path).data == data


@given(data=st.binary(min_size=1, max_size=600), step=st.integers(1, 255))
def test_image_comes_back_whatever_the_length_of_its_records(tmp_path_factory, data, step):
    path = written(tmp_path_factory.mktemp("hex"), hex_text(data, step=step))
    image = read_image(path)
    assert image.data == data
    assert image.used_bytes == len(data)


def test_gaps_read_as_erased_flash(tmp_path):
    path = written(tmp_path, record(0, 0, b"\x01") + record(0, 4, b"\x02") + END)
    image = read_image(path)
    assert image.data == b"\x01\xff\xff\xff\x02"
    assert image.used_bytes == 2


def test_order_of_records_does_not_matter(tmp_path):
    path = written(tmp_path, record(0, 2, b"\x03\x04") + record(0, 0, b"\x01\x02") + END)
    assert read_image(path).data == b"\x01\x02\x03\x04"


def test_segment_and_linear_records_move_the_base(tmp_path):
    text = record(2, 0, b"\x00\x10") + record(0, 0, b"\x02")  # 0x10 paragraphs = 0x100
    text += record(4, 0, b"\x00\x00") + record(0, 0, b"\x01") + END
    data = read_image(written(tmp_path, text)).data
    assert (data[0], data[0x100], len(data)) == (1, 2, 0x101)


def test_start_records_say_nothing_to_an_avr(tmp_path):
    text = record(3, 0, b"\0\0\0\0") + record(5, 0, b"\0\0\0\0") + hex_text(b"\x01")
    assert read_image(written(tmp_path, text)).data == b"\x01"


def test_last_byte_below_the_boot_loader_may_be_used(tmp_path):
    image = read_image(written(tmp_path, hex_text(bytes(APPLICATION_BYTES))))
    assert image.used_bytes == APPLICATION_BYTES


def test_image_that_reaches_into_the_boot_loader_is_refused(tmp_path):
    path = written(tmp_path, hex_text(bytes(APPLICATION_BYTES + 1)))
    with pytest.raises(FlashFailed, match=r"reaches to address 0x7E00") as refused:
        read_image(path)
    assert refused.value.exit_code == 11
    assert "32256" in refused.value.remedy


def test_eeprom_image_of_the_linker_is_refused(tmp_path):
    # avr-ld puts .eeprom at 0x810000.
    text = record(4, 0, b"\x00\x81") + record(0, 0, b"\x01") + END
    with pytest.raises(FlashFailed, match="0x810000"):
        read_image(written(tmp_path, text))


def test_image_without_a_reset_vector_is_refused(tmp_path):
    with pytest.raises(FlashFailed, match="begins at address 0x100"):
        read_image(written(tmp_path, hex_text(b"\x01", start=0x100)))


@pytest.mark.parametrize(
    ("text", "why"),
    [
        pytest.param(hex_text(bytes(20))[:-12], "its end is missing", id="cut_between_lines"),
        pytest.param(":1000000", "line 1 is no record", id="odd_number_of_digits"),
        pytest.param(":00\n", "line 1 is cut off", id="shorter_than_any_record"),
        pytest.param(":10000000AABB\n", "line 1 is not as long as it says", id="cut_in_a_line"),
        pytest.param(":00000001FE\n", "line 1 has a wrong checksum", id="checksum"),
        pytest.param("S00600004844521B\n", "line 1 is no record", id="motorola"),
        pytest.param(record(9, 0, b"") + END, "unknown type 9", id="type"),
        pytest.param(record(4, 0, b"\x00") + END, "unknown type 4", id="base_of_one_byte"),
        pytest.param("\n\n" + ":00000001FE\n", "line 3", id="blank_lines_count"),
    ],
)
def test_unsound_file_is_refused_by_name_and_line(tmp_path, text, why):
    path = written(tmp_path, text)
    with pytest.raises(CannotRead, match=why) as refused:
        read_image(path)
    assert str(path) in str(refused.value)
    assert refused.value.exit_code == 9


@pytest.mark.parametrize("text", [END, "", record(1, 0, b"")])
def test_file_without_data_is_refused(tmp_path, text):
    with pytest.raises(CannotRead):
        read_image(written(tmp_path, text))


def test_elf_in_place_of_a_hex_is_named_as_binary(tmp_path):
    path = tmp_path / "terazi.elf"
    path.write_bytes(b"\x7fELF\x01\x01\x01\xff")
    with pytest.raises(CannotRead, match="binary"):
        read_image(path)


def test_missing_file_is_refused(tmp_path):
    with pytest.raises(CannotRead, match="No such file"):
        read_image(tmp_path / "none.hex")


def test_folder_is_refused(tmp_path):
    with pytest.raises(CannotRead, match="directory"):
        read_image(tmp_path)


@given(noise=st.binary(max_size=200))
def test_any_bytes_are_an_image_or_a_named_error(tmp_path_factory, noise):
    path = tmp_path_factory.mktemp("noise") / "image.hex"
    path.write_bytes(noise)
    try:
        said = f"{path}: {read_image(path).used_bytes} bytes"
    except (CannotRead, FlashFailed) as named:
        said = str(named)
    assert str(path) in said

# SPDX-License-Identifier: MIT
"""Every golden vector holds inside the AVR binary, bit for bit."""

import pytest

from target_vectors.avr_core import AvrCore
from terazi.models.vectors import FOLDER, golden


@pytest.fixture(scope="module")
def avr(runner_elf):
    return AvrCore(runner_elf)


def fir_of(vector):
    """Design, or coefficients to load; first value; samples."""
    if "taps_q15" in vector.parameters:
        design = [int(tap) for tap in vector.parameters["taps_q15"].split()]
    else:
        design = vector.parameter("design")
    return design, vector.parameter("first_counts"), vector["sample_counts"]


@pytest.mark.parametrize("by_heart", [False, True], ids=["generic", "by_heart"])
@pytest.mark.parametrize("vector", golden("fir"), ids=str)
def test_fir_reproduces_vector_bit_for_bit_on_avr(avr, vector, by_heart):
    results, clipped = avr.fir(*fir_of(vector), by_heart=by_heart)
    assert results == vector["result_counts"]
    assert clipped == vector.parameter("clipped")


def test_fir_load_refuses_on_avr_what_breaks_the_contract(avr):
    assert avr.fir_load([16384, 16384])
    assert not avr.fir_load([16384, 16383, 16384])  # sum
    assert not avr.fir_load([-8192, 8192, 16384, 16384, 8192, -8192])  # gain
    assert not avr.fir_load([512] * 65)  # length
    assert not avr.fir_load([32767])


SCHEDULED = [vector for vector in golden("weight_kf_") if "schedule" in vector.parameters]


@pytest.mark.parametrize("vector", SCHEDULED, ids=str)
def test_weight_kf_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    estimates, clipped = avr.weight_kf(
        vector.parameter("schedule"), vector.parameter("first_counts"), vector["measured_counts"]
    )
    assert estimates == vector["estimate_counts_q7"]
    assert clipped == vector.parameter("clipped")


@pytest.mark.parametrize("vector", golden("mass"), ids=str)
def test_mass_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    masses_mg = [
        avr.mass_mg(net, span)
        for net, span in zip(vector["net_counts_q7"], vector["span_ug_per_count_q16"], strict=True)
    ]
    assert masses_mg == vector["mass_mg"]


def test_mass_divides_by_bytes_on_avr_whatever_remainder_and_byte_meet(avr):
    """Net 2^13 and span n * 2^13 make the product n * 2^26; n < 32000 is remainder and byte."""
    numbers = [r * 256 + b for r in range(125) for b in (0, 1, 0x7F, 0x80, 0xFF)]
    assert [avr.mass_mg(1 << 13, n << 13) for n in numbers] == [
        (2 * n + 125) // 250 for n in numbers
    ]


@pytest.mark.parametrize("vector", golden("frame_encode"), ids=str)
def test_frame_encode_gives_the_vectors_bytes_on_avr(avr, vector):
    frames = zip(
        vector["id"], vector["sequence"], vector["device_us"], vector["payload_hex"], strict=True
    )
    assert [avr.encode(*frame) for frame in frames] == vector["wire_hex"]


@pytest.mark.parametrize("vector", golden("frame_decode"), ids=str)
def test_frame_decode_says_what_the_vector_says_on_avr(avr, vector):
    answers = [avr.decode(wire) for wire in vector["wire_hex"]]
    assert [bytes(statuses) for statuses, _ in answers] == vector["status_hex"]
    assert [body for _, body in answers] == vector["body_hex"]


@pytest.mark.parametrize("vector", golden("frame_published_cobs"), ids=str)
def test_frame_decodes_the_published_cobs_packet_on_avr(avr, vector):
    # The packet is no frame of ours, so its last two bytes are taken for a CRC, which is wrong.
    for body, coded in zip(vector["body_hex"], vector["coded_hex"], strict=True):
        _, decoded = avr.decode(coded + b"\x00")
        assert decoded == body[:-2]


@pytest.mark.parametrize("vector", golden("frame_published_crc"), ids=str)
def test_crc_has_the_published_check_value_on_avr(avr, vector):
    assert [avr.crc16(data) for data in vector["data_hex"]] == vector["crc"]


def test_no_vector_is_left_out():
    replayed = ("fir_", "weight_kf_", "mass_", "frame_encode", "frame_decode", "frame_published_")
    # weight_kf_adaptive_: test_golden_adaptive_on_target.py
    replayed += ("imu_cal_", "rest_", "mahony_")  # test_golden_imu_..., ..._mahony_on_target.py
    replayed += ("scale_", "checkweigher_")  # test_golden_scale_on_target.py
    replayed += ("temperature_",)  # test_golden_temperature_on_target.py
    replayed += ("settings_", "faults_")  # test_settings_..., test_golden_faults_on_target.py
    replayed += ("zupt_",)  # test_golden_zupt_on_target.py, ..._zupt_gru_on_target.py
    assert [path.name for path in FOLDER.glob("*.csv") if not path.name.startswith(replayed)] == []

# SPDX-License-Identifier: MIT
"""The firmware's own C (shared_c), compiled for this machine: bit for bit what the device does.

Block functions work on whole numpy arrays; the classes take one sample at a time and their state
can be saved, restored and copied. Contracts: the headers in shared_c/include.
"""

from terazi.cshared.adaptive import (
    WEIGHT_KF_ADAPTIVE_VARIANTS,
    WeightKfAdaptive,
    WeightKfPair,
    weight_kf_adaptive_block,
)
from terazi.cshared.checkweighers import Checkweigher, CheckweigherEvent
from terazi.cshared.faults import Fault, Faults, FaultsAnswer, FaultsEvent, Weighed, weigh_events
from terazi.cshared.filters import (
    FIR_DESIGNS,
    WEIGHT_KF_SCHEDULES,
    Fir,
    WeightKf,
    fir_block,
    mass_mg_block,
    weight_kf_block,
)
from terazi.cshared.frames import Frame, FrameDecoder, crc16, encode_frame
from terazi.cshared.imu import REST_RATES, ImuCal, ImuTurn, Rest
from terazi.cshared.ins import Ins
from terazi.cshared.mahony import MAHONY_CONFIGS, Mahony, mahony_block
from terazi.cshared.payloads import WIRE_FINGERPRINT, pack_message, unpack_message
from terazi.cshared.scales import (
    SCALE_UNITS,
    Scale,
    ScaleFlag,
    ScaleRefusedError,
    ScaleShow,
    ScaleStatus,
)
from terazi.cshared.temperature import Temperature
from terazi.cshared.zupt import ZUPT_DETECTORS, ZUPT_RATES, Zupt
from terazi.cshared.zupt_gru import ZuptGru

__all__ = [
    "FIR_DESIGNS",
    "MAHONY_CONFIGS",
    "REST_RATES",
    "SCALE_UNITS",
    "WEIGHT_KF_ADAPTIVE_VARIANTS",
    "WEIGHT_KF_SCHEDULES",
    "WIRE_FINGERPRINT",
    "ZUPT_DETECTORS",
    "ZUPT_RATES",
    "Checkweigher",
    "CheckweigherEvent",
    "Fault",
    "Faults",
    "FaultsAnswer",
    "FaultsEvent",
    "Fir",
    "Frame",
    "FrameDecoder",
    "ImuCal",
    "ImuTurn",
    "Ins",
    "Mahony",
    "Rest",
    "Scale",
    "ScaleFlag",
    "ScaleRefusedError",
    "ScaleShow",
    "ScaleStatus",
    "Temperature",
    "Weighed",
    "WeightKf",
    "WeightKfAdaptive",
    "WeightKfPair",
    "Zupt",
    "ZuptGru",
    "crc16",
    "encode_frame",
    "fir_block",
    "mahony_block",
    "mass_mg_block",
    "pack_message",
    "unpack_message",
    "weigh_events",
    "weight_kf_adaptive_block",
    "weight_kf_block",
]

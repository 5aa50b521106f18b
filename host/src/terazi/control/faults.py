# SPDX-License-Identifier: MIT
"""The board's faults in words for people, each with its likely cause and what to do."""

from terazi.link.generated.messages import FaultFlag

# flag: (what is wrong, what to do)
WORDS = {
    FaultFlag.CABLE_OUT: (
        "no conversion comes",
        "Check the HX711's four wires: VCC at 5V, GND, DT at D2, SCK at D3.",
    ),
    FaultFlag.DOUT_STUCK: (
        "the converter's data line is stuck",
        "Check DT at D2 and SCK at D3 for a short; a dead HX711 does so, too.",
    ),
    FaultFlag.AT_RAIL: (
        "the converter stands at its rail",
        "Overloaded, or a wire of the load cell is off: check E+, E-, A+, A-.",
    ),
    FaultFlag.RATE_OUT_OF_RANGE: (
        "conversions come at no rate that an HX711 has",
        "Check the RATE pin and the 5 V supply.",
    ),
    FaultFlag.FRAMES_LOST: (
        "conversions are lost or spoilt",
        "Shorten the wires between HX711 and Uno, and keep them away from motors.",
    ),
    FaultFlag.NOISE_HIGH: (
        "far more noise than this cell has",
        "Look for vibration, a loose wire, or a cell without its screen.",
    ),
    FaultFlag.TELEMETRY_LOST: (
        "not all that was measured could be sent",
        "Weighing is not concerned. Ask for fewer messages, or for a faster line: "
        "`terazi set uart.baud=500000`.",
    ),
    FaultFlag.SETTINGS_LOST: (
        "the EEPROM held no valid settings: these are the factory's",
        "Calibrate with `terazi calibrate`, or bring back a copy: `terazi set --import FILE`.",
    ),
    FaultFlag.THERMOMETER: (
        "the thermometer does not answer",
        "Check the MPU6050's wires: SDA at A4, SCL at A5; or switch compensation off.",
    ),
    FaultFlag.IMU_LOST: (
        "the MPU-6050 was there and does not answer any more",
        "Weighing is not concerned. Check its wires: SDA at A4, SCL at A5, and its supply; "
        "attitude comes back by itself.",
    ),
    FaultFlag.ASKEW: (
        "the platform stands askew: it weighs too little",
        "Level its feet: `terazi info` tells the tilt. Where the IMU itself sits askew, allow "
        "more: `terazi set imu.tilt_limit_mrad=50`; 0 asks for nothing.",
    ),
}

# With these no weight is to be trusted (shared_c/include/faults.h says so for the device).
SPOILING = (
    FaultFlag.CABLE_OUT
    | FaultFlag.DOUT_STUCK
    | FaultFlag.AT_RAIL
    | FaultFlag.RATE_OUT_OF_RANGE
    | FaultFlag.FRAMES_LOST
    | FaultFlag.NOISE_HIGH
)


def names(faults: int) -> list[str]:
    """Each fault's name, the lowest bit first: cable out, at rail."""
    known = [flag.name.lower().replace("_", " ") for flag in FaultFlag if faults & flag]
    rest = int(faults) & ~sum(int(flag) for flag in FaultFlag)
    return [*known, f"unknown fault 0x{rest:X}"] if rest else known


def explained(faults: int) -> list[tuple[str, str, str]]:
    """(name, what is wrong, what to do) for each."""
    return [(names(flag)[0], *words) for flag, words in WORDS.items() if faults & flag]

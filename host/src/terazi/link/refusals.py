# SPDX-License-Identifier: MIT
"""Why a board says no, in words for people, each with what to do about it."""

from terazi.errors import CommandRefused
from terazi.link.generated.messages import (
    CalibrateEnd,
    CalibrateKnown,
    CalibratePoint,
    CountPieces,
    ResetCounts,
    Result,
    SetSetting,
    Tare,
    Zero,
)

# result: (what it says, what to do)
WORDS = {
    Result.UNKNOWN_COMMAND: (
        "unknown command",
        "Its firmware cannot do that: put this version's on it with `terazi flash`.",
    ),
    Result.WRONG_LENGTH: (
        "wrong length",
        "Its firmware and this host are not of one version: `terazi flash`.",
    ),
    Result.OUT_OF_RANGE: ("out of range", ""),
    Result.WRONG_STATE: (
        "not now: it has no sample yet",
        "`terazi info` says whether the converter answers.",
    ),
    Result.NOT_STABLE: (
        "the load does not stand still",
        "Wait until nothing moves, keep wind and vibration off, or give it longer with --wait.",
    ),
    Result.CALIBRATING: (
        "a calibration is under way",
        "End it, or forget it with `terazi calibrate --abort`.",
    ),
    Result.NOT_CALIBRATING: (
        "no calibration is under way",
        "The board has started anew, or another program has ended it: begin again.",
    ),
    Result.TOO_FEW_POINTS: (
        "a calibration needs two points or more",
        "Take one with nothing on the scale and one near Max.",
    ),
    Result.TOO_MANY_POINTS: ("a calibration holds eight points at most", ""),
    Result.NOT_MONOTONE: (
        "the points contradict one another: more mass must give more counts all the way, or fewer "
        "all the way",
        "Take the wrong point again; `terazi calibrate` shows which one does not fit.",
    ),
    Result.TOO_STEEP: (
        "two masses differ by hardly any counts",
        "Was the mass on the scale? `terazi watch` shows whether the cell follows a load.",
    ),
    Result.TOO_LIGHT: (
        "too little lies there to count by",
        "Put on more pieces: 20 e at least, and 2 mg a piece.",
    ),
    Result.BUSY: ("settings are being written", "Ask again in a second."),
    Result.NOTHING_THERE: ("there is nothing of that kind", ""),
    Result.CONTRADICTS: (
        "the value does not go with those of other settings",
        "e is at most Max / 16 and the stable band at most e / 2; under and step are at most Max; "
        "the display's division must suit Max; leave is below enter, and class limits rise.",
    ),
    Result.WRITE_PROTECTED: (
        "it is not set by hand",
        "Points are written by `terazi calibrate`, zero and tare by `terazi tare`.",
    ),
}

# Where a result says more of one command.
SPECIAL = {
    (Tare, Result.OUT_OF_RANGE): (
        "there is nothing to tare, or it is more than Max",
        "Opening the port starts the board, and up to 10 % of Max that lies there then is zero "
        "already: put the container on afterwards, as in `terazi watch`, key t.",
    ),
    (Zero, Result.OUT_OF_RANGE): (
        "the load is further than 2 % of Max from the zero at the start",
        "Take the load off, or tare it; a zero that has wandered so far wants a calibration.",
    ),
    (SetSetting, Result.NOTHING_THERE): (
        "it knows no such setting",
        "Its firmware and this host are not of one version: `terazi flash`.",
    ),
    (CalibratePoint, Result.OUT_OF_RANGE): ("the mass is beyond 500 kg", ""),
    (CalibrateKnown, Result.OUT_OF_RANGE): ("the mass is beyond 500 kg, or the counts", ""),
    (CalibrateEnd, Result.OUT_OF_RANGE): (
        "a point is beyond what the scale can hold",
        "500 kg and 2^23 counts are the limits.",
    ),
    (CountPieces, Result.OUT_OF_RANGE): ("the number of pieces is 1 to 65535", ""),
    (ResetCounts, Result.WRONG_STATE): (
        "the checkweigher is off",
        "Switch it on: terazi set checkweigher.on=true",
    ),
}


def refusal(whose: str, command, result: int) -> CommandRefused:
    """The error for a result that is not OK."""
    words, remedy = SPECIAL.get((type(command), result)) or WORDS.get(
        result, (f"result {int(result)}, which this host does not know", "")
    )
    name = type(command).__name__
    return CommandRefused(f"{whose} refuses {name}: {words}", remedy=remedy, result=result)

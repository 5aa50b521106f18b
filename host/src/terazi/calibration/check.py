# SPDX-License-Identifier: MIT
"""A weighing that checks a calibration, beside what class III allows."""

from terazi.calibration.points import check_mass_mg
from terazi.calibration.talk import Talk
from terazi.control.quantities import parse_mass_mg, show_mass
from terazi.errors import CommandRefused, UsageError
from terazi.link.generated.messages import Point

UNDER_WAY_S = 1.0  # Enter is pressed while a hand is still there


def class_iii_e(load_e: float) -> float:
    """Greatest error of class III at a load, both in e (R76, initial verification)."""
    return 0.5 if load_e <= 500 else 1.0 if load_e <= 2000 else 1.5


def suggestion(points: list[Point], interval_mg: int) -> str:
    """Which mass would tell the most."""
    mass = show_mass(check_mass_mg(points), interval_mg)
    return f"To check it, weigh something that you know, best about {mass}."


def check(talk: Talk, points: list[Point], interval_mg: int, wait_s: float) -> int | None:
    """Weigh a known mass; gives by how many mg it is off, or None where nothing was weighed."""
    talk.tell(suggestion(points, interval_mg))
    text = talk.terminal.ask("Its mass, or Enter to end:")
    talk.balance.fresh()
    if not text:
        return None
    try:
        known_mg = parse_mass_mg(text)
        talk.put_on(f"Put {show_mass(known_mg, interval_mg)} on")
        talk.balance.follow(UNDER_WAY_S)
        weight = talk.wait_stable(wait_s)
    except (CommandRefused, UsageError) as error:
        talk.tell_error(error)
        return None
    off_mg = weight.net_mg - known_mg
    off_e = off_mg / interval_mg
    bound_e = class_iii_e(abs(known_mg) / interval_mg)
    is_within = abs(off_e) <= bound_e
    talk.tell(
        f"It weighs {show_mass(weight.net_mg, interval_mg)}: {off_e:+.2f} e, "
        f"{'within' if is_within else 'beyond'} class III's {bound_e:g} e.",
        tone="good" if is_within else "bad",
    )
    return off_mg

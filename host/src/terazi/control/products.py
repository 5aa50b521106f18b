# SPDX-License-Identifier: MIT
"""The device as a checkweigher: switched on, and what it says of each product that passes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from terazi.control.settings import apply_settings
from terazi.errors import NoAnswer, TeraziError
from terazi.link import Link
from terazi.link.generated.messages import Product, Sample

SILENCE_S = 5.0  # of the device, on the host's clock


@dataclass
class Passed:
    """Times are device_us, wraps undone."""

    products: list[tuple[int, Product]] = field(default_factory=list)  # when each left
    samples: list[tuple[int, int]] = field(default_factory=list)  # when, raw counts


def switch_on(link: Link, config: Mapping) -> None:
    """Let the device weigh products; config has the fields of checkweigher_config_t."""
    wanted = {}
    for name, value in config.items():
        if isinstance(value, list):
            wanted |= {f"checkweigher.{name}_{at}": each for at, each in enumerate(value)}
        else:
            wanted[f"checkweigher.{name}"] = value
    apply_settings(link, wanted)
    apply_settings(link, {"checkweigher.on": 1})


def collect(
    link: Link, until_us: int, progress: Callable[[int], None] = lambda _count: None
) -> Passed:
    """All products and samples until the device's clock says until_us.

    progress hears how many products have passed. Raises NoAnswer if the device falls silent,
    TeraziError if it starts anew or a frame is lost.
    """
    passed, boot = Passed(), link.stream.boot
    lost, heard_s = link.stream.frames_lost, link.now_s()
    while True:
        received = link.poll(0.1)
        if link.stream.boot != boot or link.stream.frames_lost != lost:
            raise TeraziError(f"{link.name} started anew, or some of its frames were lost")
        for one in received:
            heard_s = one.host_s
            if isinstance(one.message, Product):
                passed.products.append((one.device_us, one.message))
                progress(len(passed.products))
            elif isinstance(one.message, Sample):
                passed.samples.append((one.device_us, one.message.raw_counts))
                if one.device_us >= until_us:
                    return passed
        if link.now_s() - heard_s > SILENCE_S:
            raise NoAnswer(f"{link.name} fell silent while products passed")

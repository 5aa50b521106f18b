# SPDX-License-Identifier: GPL-3.0-or-later
"""Offer a simulated Uno on a pseudo-terminal; its path is the first line printed.

Open that path as the serial port of a real board: pyserial, avrdude, the Arduino IDE. Opening
it resets the chip and starts the scenario anew. Ctrl-C or SIGTERM ends it.
"""

import argparse
import contextlib
import os
import pathlib
import select
import signal
import sys

EXIT_USAGE = 2
USUAL_DEGC = 25.0


def _parser():
    parser = argparse.ArgumentParser(prog="python -m virtual_uno", description=__doc__)
    parser.add_argument("--elf", help="program to run, ELF or Intel HEX")
    parser.add_argument(
        "--boot", metavar="HEX", help="boot loader; the word optiboot builds and takes that one"
    )
    parser.add_argument(
        "--flash-image",
        metavar="HEX",
        help="flash contents: read at the start if the file exists, written at the end",
    )
    parser.add_argument("--link", metavar="PATH", help="symbolic link to the pseudo-terminal")
    parser.add_argument(
        "--speed", type=float, default=1.0, help="simulated seconds a second; 0 = all it can"
    )
    parser.add_argument("--rate", type=float, default=80.0, help="conversions a second")
    parser.add_argument("--jitter", type=float, default=0.0, metavar="S", help="rms, seconds")
    parser.add_argument("--noise", type=float, default=0.0, metavar="COUNTS", help="rms, counts")
    parser.add_argument("--seed", type=int, default=1, help="of noise, jitter and SRAM contents")
    parser.add_argument(
        "--scenario",
        default="0",
        metavar="WHAT",
        help="FILE.npz, module:function (seconds since reset to grams) or grams",
    )
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="WHAT@START[..END]",
        help="misbehave then, in seconds since reset: cable_out@3..5, noise,counts=1e5@8..9, "
        "glitch@12; may be given again; README names them all",
    )
    parser.add_argument(
        "--faults-by-word",
        action="store_true",
        help="misbehave as lines of standard input say: cable_out, then clear",
    )
    parser.add_argument(
        "--imu", choices=("none", "mpu6050"), default="none", help="what is on the two-wire bus"
    )
    parser.add_argument(
        "--mag",
        choices=("none", "qmc5883l", "hmc5883l"),
        default="none",
        help="a magnetometer beside it",
    )
    parser.add_argument(
        "--motion",
        default="still",
        metavar="WHAT",
        help="of the board: still, rocking, or FILE.npz, of BROAD or a walk",
    )
    parser.add_argument(
        "--temperature",
        type=float,
        metavar="DEGC",
        help="of the IMU; else temperature_c of FILE.npz, else 25",
    )
    parser.add_argument("--truth", metavar="CSV", help="write t_s, load_g, counts of conversions")
    parser.add_argument("--vcd", metavar="FILE", help="record SCK, DOUT, TX and RX")
    parser.add_argument("--seconds", type=float, help="end after so many simulated seconds")
    return parser


def _words():
    """Lines that have come in on standard input since; never waits."""
    while select.select([sys.stdin], [], [], 0)[0]:
        line = sys.stdin.readline()
        if not line:
            return
        yield line


def _follow_words(clock):
    from virtual_uno.faults import FaultError

    for words in _words():
        try:
            clock.say(words)
        except FaultError as error:
            print(f"virtual Uno: {error}", file=sys.stderr, flush=True)


def _put_link(path, target):
    """A symbolic link, put in place at once; never over anything that is not a link."""
    path = pathlib.Path(path)
    if path.exists() and not path.is_symlink():
        raise OSError(f"{path} exists and is no link")
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    fresh.symlink_to(target)
    os.replace(fresh, path)


def _take_link(path, target):
    with contextlib.suppress(OSError):
        if os.readlink(path) == target:
            os.unlink(path)


def _make_uno(options, scenario):
    from virtual_uno.optiboot import optiboot_hex
    from virtual_uno.program import read_hex
    from virtual_uno.uno import Uno

    uno = Uno(
        options.elf,
        boot=optiboot_hex() if options.boot == "optiboot" else options.boot,
        rate_sps=options.rate,
        jitter_s=options.jitter,
        noise_counts=options.noise,
        seed=options.seed,
    )
    if options.flash_image and os.path.exists(options.flash_image):
        for address, data in read_hex(options.flash_image):
            uno.load_flash(address, data)
    uno.load(grams=scenario.load_g)
    _fit_bus(uno, options, scenario)
    return uno


def _fit_bus(uno, options, scenario):
    from virtual_uno.motion import read_motion

    motion = read_motion(options.motion)
    if options.imu != "none":
        uno.imu.fit().noise(seed=options.seed)
        uno.imu.feel(
            acc_g=motion.acc_g,
            gyro_deg_s=motion.gyro_deg_s,
            temperature_c=_temperature(options, scenario),
        )
    if options.mag != "none":
        uno.mag.fit(options.mag).feel(motion.field_ut)


def _temperature(options, scenario):
    if options.temperature is not None:
        return options.temperature
    return USUAL_DEGC if scenario.temperature_c is None else scenario.temperature_c


def _serve(options, stack):
    from virtual_uno.bridge import Bridge
    from virtual_uno.faults import FaultClock, Timed
    from virtual_uno.program import write_hex
    from virtual_uno.scenario import read_scenario
    from virtual_uno.truth import TruthFile

    scenario = read_scenario(options.scenario)
    uno = _make_uno(options, scenario)
    truth = TruthFile(options.truth, uno, scenario) if options.truth else None
    clock = FaultClock(uno, [Timed.parse(text) for text in options.fault])

    def on_reset():
        clock.restart()
        if truth:
            truth.restart()

    def on_slice():
        if options.faults_by_word:
            _follow_words(clock)
        clock.look()
        if truth:
            truth.write()

    bridge = Bridge(uno, on_reset=on_reset, on_slice=on_slice)
    stack.callback(bridge.close)
    if truth:
        stack.callback(truth.close)
    if options.flash_image:
        stack.callback(lambda: write_hex(options.flash_image, uno.flash))
    if options.vcd:
        stack.enter_context(uno.vcd(options.vcd))
    if options.link:
        _put_link(options.link, bridge.path)
        stack.callback(_take_link, options.link, bridge.path)
    signal.signal(signal.SIGTERM, bridge.stop)
    signal.signal(signal.SIGINT, bridge.stop)
    print(bridge.path, flush=True)
    bridge.run(options.speed, options.seconds)
    stats = uno.stats
    print(
        f"virtual Uno: {uno.seconds:.2f} s simulated, {bridge.resets} opened, "
        f"{stats['watchdog_resets']} watchdog resets, {stats['tx_bytes']} bytes sent, "
        f"{stats['hx711']['conversions']} conversions",
        file=sys.stderr,
    )


def main(arguments=None):
    """Run the program; returns its exit code."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if not (options.elf or options.boot or options.flash_image):
        parser.error("nothing to run: give --elf, --boot or --flash-image")
    if options.speed < 0 or (options.seconds is not None and options.seconds <= 0):
        parser.error("--speed must not be negative and --seconds must be positive")
    if options.temperature is not None and options.imu == "none":
        parser.error("--temperature needs a part that feels it: --imu mpu6050")
    if options.motion != "still" and (options.imu, options.mag) == ("none", "none"):
        parser.error("--motion needs a part that feels it: --imu mpu6050, --mag qmc5883l")
    try:
        with contextlib.ExitStack() as stack:
            _serve(options, stack)
    except (OSError, ValueError, ImportError) as error:
        print(f"virtual Uno: {error}", file=sys.stderr)
        return EXIT_USAGE
    except RuntimeError as error:
        print(f"virtual Uno: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

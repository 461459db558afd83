"""``autobalance orders RECORD [RECORD_B]``: spectrum, orders and sources of a recorded signal."""

from __future__ import annotations

import argparse
from typing import Any

from autobalance.command.options import add_json, add_plots, add_set
from autobalance.errors import UsageError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("record", metavar="RECORD", help="CSV, WAV, MAT, TDMS (extra) or UFF58 (extra)")
    parser.add_argument(
        "other", metavar="RECORD_B", nargs="?", help="a second one to compare, order by order"
    )
    parser.add_argument("--channel", metavar="NAME", help="which, where several are no tacho")
    parser.add_argument("--sample-rate", type=float, metavar="HZ", help="where the file has none")
    parser.add_argument(
        "--calibration",
        action="append",
        default=[],
        metavar="NAME=FACTOR",
        help="multiplies a channel; or its sensitivity, NAME=100mV/g; repeatable",
    )
    parser.add_argument(
        "--quantity",
        choices=("acceleration", "velocity", "displacement"),
        help="integrate channels of motion to it, from 2 Hz on: m/s², mm/s, µm",
    )
    _add_speed(parser)
    _add_spectrum(parser)
    parser.add_argument(
        "--bearing", metavar="K=V,...", help="balls=9,ball=7.94,pitch=39.04,contact=0[,speed=1]: its defects"
    )
    parser.add_argument("--band", metavar="LOW,HIGH", help="of the envelope, Hz (the most peaked one)")
    parser.add_argument("--axes", metavar="X,Y", help="two channels: rotating or reciprocating unbalance")
    parser.add_argument("--job", metavar="JOB.toml", help="the engine that was recorded, for the sources")
    add_set(parser)
    parser.add_argument(
        "--drive", metavar="DRIVE.toml", help="[[gear]], [[belt]] and [[shaft]] that the crank drives"
    )
    parser.add_argument(
        "--campbell", metavar="REPORT.json", help="of rotor or torsion: its frequencies over the waterfall"
    )
    parser.add_argument(
        "-o", "--output", metavar="DIR", help="write the report and a page to zoom into to DIR"
    )
    add_json(parser)
    add_plots(parser)


def _add_speed(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--speed-rpm", type=float, metavar="N", help="constant speed")
    parser.add_argument("--tacho", metavar="NAME", help="channel with the pulses")
    parser.add_argument("--pulses-per-rev", type=int, default=1, metavar="N", help="of the tacho (1)")
    parser.add_argument("--threshold", type=float, metavar="V", help="pulses rise through it (midway)")


def _add_spectrum(parser: argparse.ArgumentParser) -> None:
    windows = ("hann", "hamming", "blackman", "flattop", "rect")
    parser.add_argument("--window", choices=windows, default="hann", help="of the spectrum (hann)")
    parser.add_argument("--max-order", type=float, default=12.0, metavar="N", help="highest order (12)")
    parser.add_argument("--peaks", type=int, default=20, metavar="N", help="how many of the spectrum (20)")
    parser.add_argument("--natural", action="store_true", help="natural frequencies from a run-up or sweep")
    parser.add_argument("--excitation", metavar="NAME", help="with --natural: the channel of the force")
    parser.add_argument("--frequencies", metavar="HZ,HZ,...", help="crossings of these with the orders")


def run(arguments: argparse.Namespace) -> int:
    """Analyse the record; 0 unless it or an option is bad."""
    from autobalance.api.orders import orders
    from autobalance.command.finish import finish
    from autobalance.command.progress import shown

    _check(arguments)
    with shown() as progress:
        result = orders(
            arguments.record,
            arguments.other,
            channel=arguments.channel,
            sample_rate=arguments.sample_rate,
            calibration=_calibration(arguments.calibration),
            quantity=arguments.quantity,
            speed_rpm=arguments.speed_rpm,
            tacho=arguments.tacho,
            pulses_per_rev=arguments.pulses_per_rev,
            threshold=arguments.threshold,
            window=arguments.window,
            max_order=arguments.max_order,
            peaks=arguments.peaks,
            natural=arguments.natural,
            excitation=arguments.excitation,
            frequencies=_numbers("--frequencies", arguments.frequencies),
            bearing=_bearing(arguments.bearing),
            band=_pair("--band", _numbers("--band", arguments.band)),
            axes=_pair("--axes", None if arguments.axes is None else tuple(arguments.axes.split(","))),
            job=arguments.job,
            settings=arguments.settings,
            drive=arguments.drive,
            campbell=arguments.campbell,
            progress=progress,
        )
    read = (arguments.record, arguments.other, arguments.job, arguments.drive, arguments.campbell)
    return finish(arguments, result, sources=tuple(each for each in read if each is not None))


def _check(arguments: argparse.Namespace) -> None:
    if arguments.speed_rpm is not None and arguments.tacho is not None:
        raise UsageError("--speed-rpm and --tacho are both given; one of them tells the speed")
    if arguments.settings and arguments.job is None:
        raise UsageError("--set goes with --job; a record has no keys")
    if arguments.excitation is not None and not arguments.natural:
        raise UsageError("--excitation is given without --natural")
    if arguments.threshold is not None and arguments.tacho is None:
        raise UsageError("--threshold is given without --tacho")


def _calibration(given: list[str]) -> dict[str, float | str]:
    found: dict[str, float | str] = {}
    for item in given:
        name, sign, factor = item.partition("=")
        if not sign or not name or not factor:
            raise UsageError(f"--calibration is {item!r}; must be NAME=FACTOR")
        found[name] = factor
    return found


def _numbers(option: str, given: str | None) -> tuple[float, ...] | None:
    if given is None:
        return None
    try:
        return tuple(float(word) for word in given.split(","))
    except ValueError:
        raise UsageError(f"{option} is {given!r}; must be numbers with commas between") from None


def _pair(option: str, given: tuple[Any, ...] | None) -> tuple[Any, Any] | None:
    if given is None:
        return None
    if len(given) != 2:
        raise UsageError(f"{option} has {len(given)} values; two are needed, with a comma between")
    return given[0], given[1]


def _bearing(given: str | None) -> dict[str, float] | None:
    if given is None:
        return None
    found = {}
    for item in given.split(","):
        key, sign, value = item.partition("=")
        try:
            found[key.strip()] = float(value)
        except ValueError:
            sign = ""
        if not sign:
            raise UsageError(f"--bearing has {item!r}; must be KEY=NUMBER,KEY=NUMBER")
    return found

"""Options for files and units of results, which public functions do not have."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.errors import BodiesError, UsageError
from autobalance.report.output_kinds import KINDS, choices

if TYPE_CHECKING:
    from autobalance.report.material import Choice


Adder = Callable[[argparse.ArgumentParser], None]


def add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--json",
        metavar="FILE",
        help="file for the report as JSON; - prints it and nothing else (default: not written)",
    )


def add_units(parser: argparse.ArgumentParser) -> None:
    """Offer ``--units``; ``main`` fills in those of the shop by default."""
    parser.add_argument(
        "--units",
        choices=("metric", "inch"),
        help="units of the printed summary; inch is in, oz and oz·in; files stay metric "
        "(default: units of the shop, else metric)",
    )


def add_shop_units(parser: argparse.ArgumentParser) -> None:
    """Offer ``--units`` where a shop may say in which it works."""
    parser.add_argument(
        "--units",
        choices=("metric", "inch"),
        help="units of summary, page, sheet and pictures; inch is in, oz and oz·in; "
        "report.json and solids stay metric (default: units of the shop, else metric)",
    )


def add_verbose(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-v", "--verbose", action="store_true", help="print all lines of the result")


def add_open(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--open", action="store_true", help="open the page in the browser (default: print its path)"
    )


def add_strict(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--strict",
        action="store_true",
        help="exit code 4 also if the verdict is not proven: residual and uncertainty together exceed the "
        "permissible unbalance, or other cylinders may be the main journals "
        "(default: only the residual decides)",
    )


def add_output(what: str, usual: str = "not written") -> Adder:
    """Return an adder of ``-o DIR``; ``what`` names the files that are written there."""

    def add(parser: argparse.ArgumentParser) -> None:
        parser.add_argument("-o", "--output", metavar="DIR", help=f"folder for {what} (default: {usual})")

    return add


def add_series(what: str) -> Adder:
    """Return an adder of ``--series FILE.csv``; ``what`` names its rows."""

    def add(parser: argparse.ArgumentParser) -> None:
        parser.add_argument("--series", metavar="FILE.csv", help=f"file for {what} (default: not written)")

    return add


def add_plots(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--plots", metavar="DIR", help="folder for plots, each as SVG and PNG (default: not written)"
    )


def add_pages(parser: argparse.ArgumentParser) -> None:
    """Offer ``--only``, ``--no-report`` and ``--paper``, which choose the files for people."""
    left_out = [name for name, kind in KINDS.items() if not kind.is_usual]
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        "--only",
        metavar="LIST",
        type=kinds_of,
        help=f"kinds of file to write in addition to the solid and report.json, with commas: "
        f"{', '.join(choices())} (default: all except {', '.join(left_out)})",
    )
    which.add_argument(
        "--no-report",
        action="store_true",
        help="write the solid and report.json only: no page, sheet or picture",
    )
    parser.add_argument(
        "--paper", choices=("A4", "Letter"), default="A4", help="paper of sheet.pdf (default: A4)"
    )
    add_zero(parser)


def add_zero(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--zero",
        choices=("keyway", "crankpin"),
        default="keyway",
        help="zero of the angles on the sheet (default: the keyway, or crankpin 1 without a keyway)",
    )


def kinds_of(text: str) -> tuple[str, ...]:
    """Return the kinds of output that a list with commas names."""
    kinds = tuple(word.strip() for word in text.split(",") if word.strip())
    for kind in kinds:
        if kind not in choices():
            raise argparse.ArgumentTypeError(f"{kind!r} is not one of {', '.join(choices())}")
    if not kinds:
        raise argparse.ArgumentTypeError(f"name at least one of {', '.join(choices())}")
    return kinds


def chosen_pages(arguments: argparse.Namespace) -> Choice:
    """Return the kinds of files that the arguments ask for."""
    from autobalance.report.bundle import choice_of

    only = () if arguments.no_report else arguments.only
    return choice_of(only, arguments.paper, arguments.units, zero=arguments.zero)


# Text of the command line as values of Python: numbers, pairs, tables, units.


def numbers(option: str, text: str) -> tuple[float, ...]:
    """Return numbers with commas between."""
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError:
        raise UsageError(
            f"{option} is {text!r}; must be numbers with commas between, for example 0,0.5,1"
        ) from None


def places(option: str, texts: Sequence[str]) -> list[tuple[float, ...]] | None:
    """Return places "X,Y,Z"; none of them for the one text "none", None if nothing was typed."""
    if not texts:
        return None
    if list(texts) == ["none"]:
        return []
    found = [numbers(option, text) for text in texts]
    for text, place in zip(texts, found, strict=True):
        if len(place) != 3:
            raise UsageError(f"{option} is {text!r}; expected three numbers X,Y,Z [mm], or none")
    return found


def number_pair(option: str, text: str) -> tuple[float, float]:
    low, high = _two(option, numbers(option, text))
    return low, high


def word_pair(option: str, text: str) -> tuple[str, str]:
    first, second = _two(option, text.split(","))
    return first, second


def _two(option: str, values: Sequence[Any]) -> Sequence[Any]:
    if len(values) != 2:
        raise UsageError(f"{option} has {len(values)} values; expected two, with a comma between")
    return values


def number_table(option: str, text: str) -> dict[str, float]:
    """Return ``KEY=NUMBER,KEY=NUMBER`` as a mapping."""
    table = {}
    for item in text.split(","):
        key, sign, value = item.partition("=")
        try:
            table[key.strip()] = float(value)
        except ValueError:
            sign = ""
        if not sign:
            raise UsageError(f"{option} has {item!r}; must be KEY=NUMBER,KEY=NUMBER")
    return table


def factors_by_name(option: str, texts: Sequence[str]) -> dict[str, float | str]:
    """Return texts ``NAME=FACTOR`` as a mapping; a factor may be a sensitivity, as text."""
    factors: dict[str, float | str] = {}
    for item in texts:
        name, sign, factor = item.partition("=")
        if not sign or not name or not factor:
            raise UsageError(f"{option} is {item!r}; must be NAME=FACTOR")
        factors[name] = factor
    return factors


def settings(option: str, texts: Sequence[str]) -> list[str]:
    """Return texts ``KEY=VALUE`` as they are."""
    for text in texts:
        key, sign, _ = text.partition("=")
        if not sign or not key.strip():
            raise UsageError(f"{option} {text!r} is not KEY=VALUE; expected for example balance.factor=0.5")
    return list(texts)


def dimensions(option: str, texts: Sequence[str]) -> dict[str, Any]:
    """Return texts ``KEY=VALUE`` as a mapping, each value as TOML or, if it is not TOML, as text."""
    import tomllib

    from autobalance.toml_files.document import refuse_deep

    sizes: dict[str, Any] = {}
    for text in texts:
        key, equals, value = (each.strip() for each in text.partition("="))
        if not (key and equals):
            raise UsageError(f"{option} {text!r} is not KEY=VALUE; expected for example stroke_mm=58")
        try:
            refuse_deep(value)
            sizes[key] = tomllib.loads(f"value = {value}")["value"]
        except (ValueError, RecursionError):  # TOMLDecodeError is a ValueError
            sizes[key] = value
    return sizes


def wanted(option: str, texts: Sequence[str]) -> dict[str, float]:
    """Return texts ``KEY=NUMBER`` as a mapping, ``--suggest`` alone as an empty one."""
    targets = {}
    for text in filter(None, texts):
        key, equals, value = text.partition("=")
        try:
            targets[key.strip()] = float(value if equals else "none")
        except ValueError:
            raise UsageError(
                f"{option} {text!r}; must be balance_factor=NUMBER or inertia_kg_mm2=NUMBER"
            ) from None
    return targets


def body_of(text: str | None, named: bool) -> Any:
    """Return the body that ``--body`` asks for: a number, a name where the format has names, or all."""
    if text in (None, "all"):
        return text
    if str(text).isdecimal() and int(str(text)) >= 1:
        return int(str(text))
    if text and named:
        return text
    raise UsageError(f"--body is {text!r}; must be a number from 1, or all")


@contextmanager
def bodies_named(*flags: str) -> Iterator[None]:
    """Name the options that choose among bodies where an error asks for one."""
    try:
        yield
    except BodiesError as error:
        raise BodiesError(f"{error} ({', '.join(flags)})", error.bodies) from None


def unit_or_mm(unit: str | None, path: Path) -> str | None:
    """Return the unit of a file: mm, with a warning, if neither the option nor the format gives one."""
    from autobalance.command.console import warn
    from autobalance.solid.formats.registry import needs_unit

    if unit is not None or not needs_unit(path) or not path.is_file():
        return unit
    warn(f"{path.suffix.upper()[1:]} has no unit: taken as mm; --unit sets another")
    return "mm"


def unbalance_unit(text: str) -> str:
    """Return the name of a unit of unbalance, however it is typed: ``oz-in``, ``gmm``, ``KG.MM``."""
    from autobalance.toml_files.typed_units import unbalance_unit as named
    from autobalance.units import G_MM_PER

    unit = named(text)
    if unit is None:
        raise argparse.ArgumentTypeError(f"{text!r} is not one of {', '.join(G_MM_PER)} (oz-in, gmm, ...)")
    return unit


def mass_unit(text: str) -> str:
    """Return the name of a unit of mass in any case."""
    from autobalance.units import G_PER

    if text.lower() not in G_PER:
        raise argparse.ArgumentTypeError(f"{text!r} is not one of {', '.join(G_PER)}")
    return text.lower()


def length_unit(text: str) -> str:
    """Return the name of a unit of length in any case; inches are ``inch``, ``in`` or a double quote."""
    from autobalance.units import MM_PER

    unit = {"in": "inch", '"': "inch"}.get(text.lower(), text.lower())
    if unit not in MM_PER:
        raise argparse.ArgumentTypeError(f"{text!r} is not one of {', '.join(MM_PER)}")
    return unit

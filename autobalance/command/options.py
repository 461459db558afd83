"""Options that several commands share."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from autobalance.errors import UsageError
from autobalance.report.output_kinds import KINDS, choices

if TYPE_CHECKING:
    from autobalance.report.material import Choice


def add_json(parser: argparse.ArgumentParser) -> None:
    """Offer ``--json FILE``."""
    parser.add_argument(
        "--json", metavar="FILE", help="write the report to FILE too; - prints it, and nothing else"
    )


def add_units(parser: argparse.ArgumentParser) -> None:
    """Offer ``--units``."""
    parser.add_argument(
        "--units",
        choices=("metric", "inch"),
        default="metric",
        help="units of the summary (inch: in, oz, oz·in); files stay metric",
    )


def add_speed(parser: argparse.ArgumentParser) -> None:
    """Offer ``--speed-rpm``."""
    parser.add_argument(
        "--speed-rpm", type=float, metavar="N", help="crank speed (default: balance.speed_rpm of the job)"
    )


def add_reference(parser: argparse.ArgumentParser) -> None:
    """Offer ``--reference-z``."""
    parser.add_argument(
        "--reference-z",
        type=float,
        metavar="MM",
        help="z that moments are taken about, rotor frame (default: the middle of the outermost mains)",
    )


def unbalance_unit(text: str) -> str:
    """Return the name of a unit of unbalance, however it is typed: ``oz-in``, ``gmm``, ``KG.MM``."""
    from autobalance.job.toml.typed_units import unbalance_unit as named
    from autobalance.units import G_MM_PER

    found = named(text)
    if found is None:
        raise argparse.ArgumentTypeError(f"{text!r} is none of {', '.join(G_MM_PER)} (oz-in, gmm, ...)")
    return found


def mass_unit(text: str) -> str:
    """Return the name of a unit of mass in any case."""
    from autobalance.units import G_PER

    if text.lower() not in G_PER:
        raise argparse.ArgumentTypeError(f"{text!r} is none of {', '.join(G_PER)}")
    return text.lower()


def length_unit(text: str) -> str:
    """Return the name of a unit of length in any case; inches are ``inch``, ``in`` or a double quote."""
    from autobalance.units import MM_PER

    found = {"in": "inch", '"': "inch"}.get(text.lower(), text.lower())
    if found not in MM_PER:
        raise argparse.ArgumentTypeError(f"{text!r} is none of {', '.join(MM_PER)}")
    return found


def add_set(parser: argparse.ArgumentParser) -> None:
    """Offer ``--set``."""
    parser.add_argument(
        "--set",
        dest="settings",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="set a key of the job first, balance.factor=0.5 say; may be given several times",
    )


def add_workers(parser: argparse.ArgumentParser) -> None:
    """Offer ``--workers``, ``--cluster`` and ``--cluster-timeout``."""
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=int, metavar="N", help="processes here (default: one a core)")
    where.add_argument("--cluster", metavar="tcp://HOST:PORT", help="the workers of a Dask cluster instead")
    parser.add_argument(
        "--cluster-timeout", type=float, default=10.0, metavar="S", help="how long it may take to answer (10)"
    )


def workers_given(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return what ``add_workers`` has read, as public functions take it."""
    return {
        "workers": arguments.workers,
        "cluster": arguments.cluster,
        "cluster_timeout_s": arguments.cluster_timeout,
    }


def add_plots(parser: argparse.ArgumentParser) -> None:
    """Offer ``--plots``."""
    parser.add_argument("--plots", metavar="DIR", help="write plots to DIR, each as SVG and PNG")


def add_pages(parser: argparse.ArgumentParser) -> None:
    """Offer ``--only``, ``--no-report`` and ``--paper``, which choose the files for people."""
    left_out = [name for name, kind in KINDS.items() if not kind.is_usual]
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        "--only",
        metavar="LIST",
        type=kinds_of,
        help=f"write only these kinds of file beside the solid, of {', '.join(choices())} "
        f"(default: all but {', '.join(left_out)}; json is always written)",
    )
    which.add_argument(
        "--no-report",
        action="store_true",
        help="write the solid and report.json only: no page, sheet or picture",
    )
    parser.add_argument(
        "--paper", choices=("A4", "Letter"), default="A4", help="paper of sheet.pdf (default A4)"
    )


def kinds_of(text: str) -> tuple[str, ...]:
    """Return the kinds of output that a list with commas names."""
    kinds = tuple(word.strip() for word in text.split(",") if word.strip())
    for kind in kinds:
        if kind not in choices():
            raise argparse.ArgumentTypeError(f"{kind!r} is none of {', '.join(choices())}")
    if not kinds:
        raise argparse.ArgumentTypeError(f"name at least one of {', '.join(choices())}")
    return kinds


def chosen_pages(arguments: argparse.Namespace) -> Choice:
    """Return which files the arguments ask for."""
    from autobalance.report.bundle import choice_of

    return choice_of(() if arguments.no_report else arguments.only, arguments.paper, arguments.units)


def add_suggest(parser: argparse.ArgumentParser, says: str) -> None:
    """Add ``--suggest KEY=VALUE``."""
    parser.add_argument("--suggest", action="append", nargs="?", const="", metavar="KEY=VALUE", help=says)


def suggest_of(given: list[str] | None) -> dict[str, float] | None:
    """Return what ``--suggest`` asks for; None without it.

    Raises
    ------
    UsageError
        If a value is no number.
    """
    if given is None:
        return None
    wanted = {}
    for text in filter(None, given):
        key, equals, value = text.partition("=")
        try:
            wanted[key.strip()] = float(value if equals else "none")
        except ValueError:
            raise UsageError(
                f"--suggest {text!r}; must be balance_factor=NUMBER or inertia_kg_mm2=NUMBER"
            ) from None
    return wanted


def body_of(text: str | None, named: bool) -> Any:
    """Return what ``--body`` names: a number, a name where the format has names, or all."""
    if text in (None, "all"):
        return text
    if str(text).isdecimal() and int(str(text)) >= 1:
        return int(str(text))
    if text and named:
        return text
    raise UsageError(f"--body is {text!r}; must be a number from 1, or all")

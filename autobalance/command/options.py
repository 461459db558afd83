"""Options that several commands share."""

from __future__ import annotations

import argparse


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


def add_plots(parser: argparse.ArgumentParser) -> None:
    """Offer ``--plots``."""
    parser.add_argument("--plots", metavar="DIR", help="write plots to DIR, each as SVG and PNG")

"""The tables [job] and [shop]: whose work this is, and what the shop has; kept in the report."""

from __future__ import annotations

from typing import Literal

from autobalance.declare import POSITIVE, Key

DrillSeries = Literal["mm", "inch", "letter", "number"]

JOB = Key(
    "job",
    says="customer, engine and operator; kept in the report",
    default=None,
    verbs="all",
    keys=(
        Key("part", str, "name of the part; names of papers begin with it", default=None, example="V8"),
        Key("customer", str, "name of the customer", default=None, example="A. Customer"),
        Key("engine", str, "name of the engine", default=None, example="CRF 250 R"),
        Key("serial", str, "serial number of the crank", default=None, example="C-0417"),
        Key("operator", str, "name of the operator", default=None, example="B. Turner"),
        Key("note", str, "free text", default=None, example="second set of pistons"),
    ),
)
SLUG = (
    Key("diameter_mm", float, "diameter of the slug", POSITIVE),
    Key("length_mm", float, "length of the slug", POSITIVE),
    Key("density_kg_m3", float, "density of the slug's metal", POSITIVE, 17000.0),
)
SHOP = Key(
    "shop",
    says="the shop and its equipment; kept in the report",
    default=None,
    verbs="all",
    keys=(
        Key("name", str, "name of the shop", default=None, example="Turner & Daughters, crankshafts"),
        Key("logo", str, "picture, relative to the file that names it", default=None, example="logo.png"),
        Key("units", Literal["metric", "inch"], "in which it works", default=None, example="metric"),
        Key(
            "drills",
            DrillSeries | tuple[float, ...],
            'drills available: a series, a diameter, or a list such as `[8.0, "1/2 in"]`',
            POSITIVE,
            None,
            typed="mm",
            not_empty="leave it out, or name one",
            example=[8.0, 10.0, "1/2 in"],
            or_one=True,
        ),
        Key(
            "slugs",
            says="heavy-metal slugs in stock",
            keys=SLUG,
            many=True,
            default=(),
            example=[{"diameter_mm": 25.4, "length_mm": 12.7, "density_kg_m3": 17000.0}],
        ),
        Key(
            "washers_g",
            tuple[float, ...],
            "washers that bob-weights are stacked from",
            POSITIVE,
            None,
            example=[1.0, 2.0, 5.0, 10.0],
        ),
        Key(
            "machine",
            str,
            "file of the balancing machine, for `autobalance machine`, relative to the file that names it",
            default=None,
            example="MACHINE.toml",
        ),
    ),
)

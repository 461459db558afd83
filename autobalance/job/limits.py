"""Reading of the ``[correction]`` table into the limits of each kind of correction.

The limits of a kind are a frozen dataclass. Its fields are named and typed as the keys of its table, with
their ranges in ``Annotated`` and their meanings in its docstring. The kinds are those entered in
``autobalance.correction``.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import MISSING, Field, fields
from functools import cache
from typing import Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

from autobalance.correction import KINDS, Limits
from autobalance.correction.contract import Prefer
from autobalance.correction.faces.patches import FaceLimits
from autobalance.declare import (
    ANY,
    NOT_NEGATIVE,
    Key,
    Range,
    TypedIn,
    Values,
)
from autobalance.errors import CorrectionError, JobError
from autobalance.job.balance import FACE_KEYS, LISTED, LISTED_CUTS, kinds_listed
from autobalance.job.layout import SHOP
from autobalance.toml_files.keys import read

OF_FACES = {
    "faces": "or a list of ids from `inspect`, or of points in file coordinates in mm, one on each face",
    "sector_deg": "only this part of each face: two angles about the axis, in the rotor frame",
    "max_depth_mm": "maximum depth",
    "same_depth": "one depth for all faces",
    "min_wall_mm": "metal to leave behind the new face",
}
USUAL_LIMITS = {
    "sector_deg": "all around",
    "max_depth_mm": "strength of the metal",
    "min_wall_mm": "a quarter of the web",
}

PERCENT = Range("must be 0 to 100", least=0.0, most=100.0)
PREFER = (
    'secondary objective among plans that reach the target: `"simple"` (fewest different cuts of tool and '
    'depth, then fewest cuts, then the least metal; `"same_setup"`, default of recut: first tools of earlier '
    "stages in their own places, then these tools anywhere; cuts of holes, slugs and machine steps may leave "
    "a quarter of the permissible value for it, in `recut` minus the reading's uncertainty, "
    "and no plane may become worse)"
)


OF_TOOLS = ("diameters_mm", "lengths_mm")
"""Lists that need no brackets for a single entry."""
_KEYS: dict[type[Limits], tuple[Key, ...]] = {}


def correction_key(kinds: Collection[str] | None = None) -> Key:
    """Return ``[correction]`` with a table for each kind that is entered; None: with the keys of all.

    The keys of those that are not among ``kinds`` are left out: a job that has no table of theirs is read
    without looking at them.
    """
    method: Any = Literal[(*KINDS, LISTED)]
    return Key(
        "correction",
        says="methods that remove or add metal",
        missing=f"it needs at least method: one of {', '.join(KINDS)}",
        verbs="balance, compare, recut, study, batch, design",
        keys=(
            Key(
                "method",
                method | tuple[method, ...],
                'correction method, or a list of methods to mix; `"listed"`: exactly the cuts of '
                "`[[correction.cut]]`, without a plan",
                not_empty="must name at least one method",
            ),
            Key("prefer", Prefer, PREFER, default="simple"),
            Key(
                "min_gain_percent",
                float,
                "smallest gain that is worth a cut, if the tolerance cannot be reached",
                PERCENT,
                20.0,
            ),
            Key(
                "depth_tolerance_mm",
                float,
                "tolerance of the depth of each cut",
                NOT_NEGATIVE,
                None,
                usual="not stated",
            ),
            Key(
                "keep",
                str,
                "a report whose cuts are kept, with new depths: places, tools, faces and numbers stay",
                default=None,
                usual="a new plan",
            ),
            LISTED_CUTS,
            *_shared_keys(),
            *(_table_of(name, kinds is None or name in kinds) for name in KINDS),
        ),
    )


@cache
def _shared_keys() -> tuple[Key, ...]:
    """Return the keys of the top level that kinds share."""
    hints = get_type_hints(FaceLimits, include_extras=True)
    return tuple(
        _key(each, hints, OF_FACES[each.name], USUAL_LIMITS.get(each.name, ""))
        for each in fields(FaceLimits)
        if each.name in FACE_KEYS
    )


def _table_of(name: str, with_keys: bool) -> Key:
    kind = KINDS[name]
    return Key(
        name,
        says=f"{kind.noun.lower()}; {kind.extent}s count from {kind.datum}",
        keys=_keys_of(kind.limits) if with_keys else (),
        default=None,
    )


def _keys_of(limits: type[Limits]) -> tuple[Key, ...]:
    """Return the keys of a kind's table, from its limits."""
    if limits in _KEYS:
        return _KEYS[limits]
    hints = get_type_hints(limits, include_extras=True)
    meanings = dict(_attributes(inspect.cleandoc(limits.__doc__ or "")))
    keys = tuple(_key(each, hints, meanings.get(each.name, ""), "") for each in fields(limits))
    return _KEYS.setdefault(limits, keys)


def _key(each: Field[Any], hints: Mapping[str, Any], says: str, usual: str) -> Key:
    hint = hints[each.name]
    every = getattr(hint, "__metadata__", ())
    marks = [mark for mark in every if isinstance(mark, Range)]
    typed = next((mark.unit for mark in every if isinstance(mark, TypedIn)), "")
    hint = getattr(hint, "__origin__", hint) if hasattr(hint, "__metadata__") else hint
    lists = any(get_origin(arm) is tuple and Ellipsis in get_args(arm) for arm in (hint, *get_args(hint)))
    instead = "leave it out, or name one"
    if each.name == "faces":
        instead = 'must be "auto" or name at least one face'
    elif each.name == "sectors_deg":
        instead = f"it excludes every angle; {instead}"
    return Key(
        each.name,
        hint,
        says,
        marks[0] if marks else ANY,
        None if each.default is MISSING else each.default,
        usual=usual,
        not_empty=instead if lists else "",
        typed=typed,
        or_one=each.name in OF_TOOLS,
    )


def _attributes(text: str) -> Iterator[tuple[str, str]]:
    """Yield names and descriptions of a docstring's Attributes section."""
    section = text.partition("Attributes\n----------\n")[2]
    for head, body in re.findall(r"^(\S.*)\n?((?:[ ]{4}.*\n?)*)", section, re.MULTILINE):
        heads, _, kind = head.partition(" : ")
        meaning = " ".join(body.split()).replace("``", "`").replace("None:", "not set:").rstrip(".")
        meaning = meaning[:1].lower() + meaning[1:] if meaning[1:2].islower() else meaning
        if re.fullmatch(r'"\w+" or "\w+"', kind):
            meaning = f"{kind}; {meaning}".rstrip("; ")
        for name in heads.split(", "):
            yield name, meaning


class ShopTools(NamedTuple):
    """Equipment of a shop, the default for jobs without their own.

    ``drills`` are in the form of ``[correction.drill] series``; ``in_inches`` is whether its machines are set
    in inches.
    """

    drills: Any = None
    slugs: Any = None
    in_inches: bool = False

    @classmethod
    def of(cls, values: Values) -> ShopTools:
        """Return the tools of ``[shop]``, none without that table."""
        shop = values.get("shop")
        return cls() if shop is None else cls(shop["drills"], shop["slugs"], shop["units"] == "inch")


NO_TOOLS = ShopTools()
STEP_MM, INCH_STEP_MM = 0.1, 0.127
"""Usual steps of depths: 0.1 mm, and 0.005 in where a shop works in inches."""


def correction_of(
    values: Values, raw: Mapping[str, Any], tools: ShopTools = NO_TOOLS
) -> tuple[tuple[str, ...], tuple[Limits, ...]]:
    """Return the methods of ``[correction]`` and the limits of each.

    ``raw`` is the table: the top level supplies keys that a kind's own table lacks. ``tools`` are
    those of the shop.

    Raises
    ------
    JobError
        If they contradict each other.
    """
    method = values["method"]
    if method in (LISTED, (LISTED,)):
        method = kinds_listed(values)
    elif LISTED in method:
        raise JobError(f'correction.method mixes "{LISTED}" with kinds; the list has the kind of each cut')
    elif values["cut"]:
        raise JobError(f'correction.cut lists cuts, but correction.method is not "{LISTED}"')
    methods = method if isinstance(method, tuple) else (method,)
    for place, name in enumerate(methods):
        if name in methods[:place]:
            raise JobError(f"correction.method names {name!r} twice")
    for name in KINDS:  # a table of another method than the one asked for is checked all the same
        if name in raw and name not in methods:
            _limits(values, raw, name, tools)
    return methods, tuple(_limits(values, raw, name, tools) for name in methods)


def limits_of_every_kind(raw: Mapping[str, Any]) -> dict[str, Limits]:
    """Return the limits of all kinds for a job as read: from its tables, else the defaults.

    Raises
    ------
    JobError
        If a value of a table is wrong.
    """
    table = raw.get("correction", {})
    tables = {key: raw[key] for key in ("correction", "shop") if key in raw}
    values = read({"correction": {}, **tables}, (correction_key(), SHOP))
    tools = ShopTools.of(values)
    return {name: _limits(values["correction"], table, name, tools) for name in KINDS}


def _at_hand(slugs: Any) -> dict[str, Any]:
    """Return the shop's slugs as keys of limits: of the metal and the diameter with the most lengths.

    Limits know every diameter in every length, so those of one diameter alone are sure to be available.
    """
    by_kind: dict[tuple[float, float], list[float]] = {}
    for each in slugs:
        by_kind.setdefault((each["density_kg_m3"], each["diameter_mm"]), []).append(each["length_mm"])
    (density, diameter), lengths = max(by_kind.items(), key=lambda kind: (len(kind[1]), kind[0]))
    sizes = tuple(sorted(set(lengths)))
    return {"diameters_mm": (diameter,), "lengths_mm": sizes, "density_kg_m3": density}


def _limits(values: Values, raw: Mapping[str, Any], name: str, tools: ShopTools) -> Limits:
    """Return the limits of a method: its own table, over the top level's keys where it works on faces."""
    kind = KINDS[name].limits
    own = {key: values[name][key] for key in raw.get(name, {})}
    of_faces = any(each.name == "faces" for each in fields(kind))
    shared = {key: values[key] for key in FACE_KEYS if key in raw} if of_faces else {}
    usual = {each.name: each.default for each in fields(kind)}
    if tools.drills is not None and "series" in usual:
        own = own if own.get("diameters_mm") or own.get("series") else {**own, "series": tools.drills}
    stock = {"diameters_mm", "lengths_mm", "density_kg_m3"}
    if tools.slugs and stock <= usual.keys() and not own.keys() & stock:
        own = {**own, **_at_hand(tools.slugs)}
    if tools.in_inches and usual.get("depth_step_mm") == STEP_MM:
        own = {"depth_step_mm": INCH_STEP_MM, **own}
    _refuse_empty_sector("correction.sector_deg", shared.get("sector_deg"))
    _refuse_empty_sector(f"correction.{name}.sector_deg", own.get("sector_deg"))
    try:
        return kind(**{**shared, **own})
    except CorrectionError as error:
        raise JobError(f"correction.{error}") from None


def _refuse_empty_sector(where: str, sector: object) -> None:
    if isinstance(sector, tuple) and sector[0] == sector[1]:  # a kind may call one angle so
        raise JobError(f"{where} is [{sector[0]:g}, {sector[1]:g}]; its two angles must differ")

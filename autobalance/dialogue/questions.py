"""The questions of ``start``, in their order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.balancing.plausibility import holds_two_rods, layout_name, throws_cancel
from autobalance.balancing.typed_effects import DENSITY_KG_M3
from autobalance.correction import KINDS
from autobalance.dialogue.conversation import AnswerError, Question, Talk
from autobalance.errors import JobError
from autobalance.job.from_options import typed
from autobalance.job.model import EngineParts, PartWeights, ThrowParts
from autobalance.materials import MATERIALS
from autobalance.report.files import seen_from
from autobalance.solid.formats.registry import needs_unit
from autobalance.solid.formats.table import endings
from autobalance.toml_files.table import did_you_mean
from autobalance.toml_files.typed_units import TYPED_UNITS
from autobalance.units import MM_PER

if TYPE_CHECKING:
    from autobalance.verbs.crank import Crank

YES, NO = ("y", "yes", "1", "true"), ("n", "no", "0", "false")
ROTATING, RECIPROCATING = "engine.rotating_g.all", "engine.reciprocating_g.all"
PIN = "engine.crankpin_g.crankpin"
WEIGH = (
    "Put the rod on two scales, or hang one eye and weigh the other: big end and small end.\n"
    "Weigh all parts of one rod and its piston in grams; 4.7 oz and 0.134 kg are read too.\n"
    "A sum may be typed: 95.04 + 39."
)


# --- the file -----------------------------------------------------------------------------------------------


def _cranks(talk: Talk) -> list[Path]:
    """Return the crank files of the folder, the newest first."""
    files = [path for path in talk.folder.iterdir() if path.suffix.lower() in endings() and path.is_file()]
    return sorted(files, key=lambda path: (-path.stat().st_mtime, path.name))


def _asks_file(talk: Talk) -> Sequence[str]:
    names = [path.name for path in _cranks(talk)]
    listed = [f"Crank files in {talk.folder}: {', '.join(names[:8])}"] if len(names) > 1 else []
    return (*listed, "Crank file")


def _default_file(talk: Talk) -> str | None:
    names = [path.name for path in _cranks(talk)]
    return names[0] if names else None


def _reads_file(talk: Talk, text: str) -> None:
    name = text.strip("'\"")
    path = next((each for each in (talk.folder / name, Path(name)) if each.is_file()), None)
    if path is None:
        close = did_you_mean(name, [each.name for each in _cranks(talk)])
        raise AnswerError(f"{name} does not exist in {talk.folder}{close}")
    if path.suffix.lower() not in endings():
        raise AnswerError(f"{path.suffix or name} is not a crank file; formats: {' '.join(endings())}")
    if talk.value("crankshaft.file") is not None:
        talk.drop("crankshaft", "engine", "original")
        talk.facts.clear()
    talk.set("crankshaft.file", seen_from(talk.job_file.parent, path))


def file_of(talk: Talk) -> Path:
    """Return the crank's file."""
    return talk.job_file.parent / str(talk.value("crankshaft.file"))


# --- unit and material --------------------------------------------------------------------------------------


def _length(talk: Talk) -> float:
    """Return the longest side of the crank in units of its file."""
    if "length" not in talk.facts:
        from autobalance.solid.formats.read import read

        corners = read(file_of(talk), "mm", "all").solid.mesh.vertices
        talk.facts["length"] = float((corners.max(axis=0) - corners.min(axis=0)).max())
    return float(talk.facts["length"])


def _asks_unit(talk: Talk) -> Sequence[str]:
    length = _length(talk)
    sizes = [
        f"  {unit:5}{length * mm:10.1f} mm {length * mm / MM_PER['inch']:10.2f} in"
        for unit, mm in MM_PER.items()
    ]
    return (
        f"{file_of(talk).name} has no unit. Its longest side in each unit:",
        *sizes,
        "Unit of the file",
    )


def _default_unit(talk: Talk) -> str:
    length = _length(talk)
    likely = [unit for unit, mm in MM_PER.items() if USUAL_LENGTH_MM[0] <= length * mm <= USUAL_LENGTH_MM[1]]
    return "mm" if "mm" in likely or not likely else likely[0]


USUAL_LENGTH_MM = (60.0, 1500.0)
"""Length of the cranks that people balance by hand: model engines to lorries."""


def _reads_unit(talk: Talk, text: str) -> None:
    unit = {"in": "inch", '"': "inch"}.get(text.lower(), text.lower())
    if unit not in MM_PER:
        raise AnswerError(f"{text} is not one of {', '.join(MM_PER)}")
    talk.set("crankshaft.unit", unit)
    talk.facts.pop("crank", None)


def _reads_material(talk: Talk, text: str) -> None:
    number = typed(text, "material")
    talk.drop("crankshaft.density", "crankshaft.density_kg_m3")
    talk.facts.pop("crank", None)
    if isinstance(number, float):
        low, high = DENSITY_KG_M3
        if not low <= number <= high:
            raise AnswerError(f"{number:g} kg/m³ is not the density of a metal; steel has 7850")
        talk.set("crankshaft.density_kg_m3", number)
        return
    if text not in MATERIALS:
        raise AnswerError(
            f"{text} is not one of {', '.join(MATERIALS)}, nor a density{did_you_mean(text, list(MATERIALS))}"
        )
    talk.set("crankshaft.density", text)


def _material_is_known(talk: Talk) -> bool:
    return any(talk.value(f"crankshaft.{key}") is not None for key in ("density", "density_kg_m3"))


# --- what was recognised ------------------------------------------------------------------------------------


def crank_of(talk: Talk) -> Crank:
    """Return the recognised crank."""
    if "crank" not in talk.facts:
        from autobalance.balancing.measured_crank import measure_crank
        from autobalance.runtime import Stopwatch
        from autobalance.verbs.crank import Crank
        from autobalance.verbs.crank_job import crankshaft_of_tables

        said = {k: v for k, v in talk.tables["crankshaft"].items() if k not in ("file", "crankpin_in_file")}
        crankshaft = crankshaft_of_tables(file_of(talk), said)
        talk.facts["crank"] = Crank(measure_crank(crankshaft, Stopwatch()), crankshaft)
    crank: Crank = talk.facts["crank"]
    return crank


def _asks_recognised(talk: Talk) -> Sequence[str]:
    crank = crank_of(talk)
    anatomy = crank.measured.anatomy
    rods = EngineParts(ThrowParts(1, PartWeights()))
    throw = anatomy.throws[0]
    pin = "with its crankpins" if crank.measured.holds_crankpins else "pressed up, without its crankpins"
    lines = [
        f"Recognised: {layout_name(anatomy, rods)}, stroke {2.0 * throw.crank_radius_mm:.2f} mm, {pin};",
        f"  {len(anatomy.main_journals)} main journals, {len(anatomy.webs)} webs, {crank.mass_g:.1f} g.",
    ]
    lines += [f"  In doubt: {text}" for text in crank.warnings]
    return (*lines, "Is that right (y, n)")


def _reads_recognised(talk: Talk, text: str) -> None:
    if not _yes(text):
        raise AnswerError(
            "Look at it: autobalance inspect FILE --picture crank.png. For another unit: back. For another"
            " reading of the shape, set crankshaft.main_journals, crankpins or axis_point_mm in the job."
        )
    if not crank_of(talk).measured.holds_crankpins:
        talk.set("crankshaft.crankpin_in_file", False)


def _yes(text: str) -> bool:
    if text.lower() not in (*YES, *NO):
        raise AnswerError(f"{text} is neither y nor n")
    return text.lower() in YES


def _two_rods(talk: Talk) -> bool:
    return crank_of(talk).measured.holds_crankpins and holds_two_rods(crank_of(talk).measured.anatomy)


def _reads_rods(talk: Talk, text: str) -> None:
    if not text.isdecimal() or not 1 <= int(text) <= 9:
        raise AnswerError(f"{text} is not a number of rods on a crankpin; type 1, or 2 for a vee engine")
    talk.set("engine.rods_per_throw", int(text))


# --- weights ------------------------------------------------------------------------------------------------


def _reads_old(talk: Talk, text: str) -> None:
    talk.facts["old"] = _yes(text)
    if not talk.facts["old"]:
        talk.drop("original")
        talk.open = [key for key in talk.open if not key.startswith("original.")]
    else:
        talk.leave_open("original.rotating_g.all")


def has_old(talk: Talk) -> bool:
    """Return whether the crank was balanced for other parts."""
    return (
        bool(talk.facts.get("old"))
        or "original" in talk.tables
        or any(key.startswith("original.") for key in talk.open)
    )


def weight_g(text: str, key: str) -> float:
    """Return a weight that was typed, or a sum of several with + between [g]."""
    grams = TYPED_UNITS["g"]
    total = 0.0
    for part in text.split("+"):
        value = typed(part, "the weight")
        if isinstance(value, str):
            if not grams.fits(value):
                raise AnswerError(f"{part.strip()} is not a weight; type grams, or a unit as in 4.7 oz")
            value = grams.number(value, key)
        if not value >= 0.0:
            raise AnswerError(f"{part.strip()} is below 0")
        total += value
    return round(total, 6)


def _weight(name: str, key: str, question: str, **more: Any) -> Question:
    def reads(talk: Talk, text: str) -> None:
        talk.set(key, weight_g(text, key))

    return Question(name, lambda _: (question,), reads, help=WEIGH, keys=(key,), may_be_unknown=True, **more)


def _pressed_up(talk: Talk) -> bool:
    return talk.value("crankshaft.crankpin_in_file") is False


# --- the target ---------------------------------------------------------------------------------------------


def _table_of_factors(talk: Talk) -> Sequence[str]:
    """Return the table of ``factor`` for the answers so far."""
    from autobalance.engines.factor import factor, factor_text
    from autobalance.report.display_units import ON_SCREEN

    if any(talk.value(key) is None for key in (ROTATING, RECIPROCATING)):
        return ("The weights are open, so no factor can be compared.",)
    original = talk.tables.get("original")
    tables = {key: value for key, value in talk.tables.items() if key != "original" or original}
    tables["balance"] = {}
    shaft = {key: value for key, value in tables["crankshaft"].items() if key != "file"}
    try:
        found = factor({**tables, "crankshaft": shaft}, crank_of(talk))
    except JobError as error:
        return (f"Factors cannot be compared: {error}",)
    talk.facts["present"] = found.present
    return factor_text(found.content, ON_SCREEN["metric"]).rpartition("\n\n")[0].splitlines()


def _asks_factor(talk: Talk) -> Sequence[str]:
    return (*_table_of_factors(talk), "Balance factor (0 to 1, 28 %, or original)")


def _default_factor(talk: Talk) -> str:
    anatomy = crank_of(talk).measured.anatomy
    if has_old(talk):
        return "original"
    if throws_cancel(anatomy):
        return "0"
    if len(anatomy.throws) > 1 or (talk.value("engine.rods_per_throw") or 1) > 1:
        return "0.5"
    present = talk.facts.get("present")
    return "0.5" if present is None or not 0.0 <= present <= 1.0 else f"{present:.4f}"


def _reads_factor(talk: Talk, text: str) -> None:
    value = typed(text, "the factor")
    if value == "original":
        if not has_old(talk):
            raise AnswerError("original needs the old parts, which are missing; type a number from 0 to 1")
        talk.set("balance.factor", "original")
        return
    if isinstance(value, str) and TYPED_UNITS["share"].fits(value):
        value = TYPED_UNITS["share"].number(value, "balance.factor")
    if not isinstance(value, float) or not 0.0 <= value <= 1.0:
        raise AnswerError(f"{text} is not a balance factor; type a number from 0 to 1, such as 0.5 or 50 %")
    talk.set("balance.factor", value)


def _number(key: str, unit: str, low: float, high: float, what: str) -> Callable[[Talk, str], None]:
    def reads(talk: Talk, text: str) -> None:
        value = typed(text, what)
        if isinstance(value, str) and TYPED_UNITS[unit].fits(value):
            value = TYPED_UNITS[unit].number(value, key)
        if not isinstance(value, float) or not low <= value <= high:
            raise AnswerError(f"{text} is not a {what}; type a number from {low:g} to {high:g}")
        talk.set(key, value)

    return reads


def _reads_method(talk: Talk, text: str) -> None:
    names = [each.strip() for each in text.lower().split(",") if each.strip()]
    for name in names:
        if name not in KINDS:
            raise AnswerError(f"{name} is not one of {', '.join(KINDS)}{did_you_mean(name, list(KINDS))}")
    talk.set("correction.method", names[0] if len(names) == 1 else names)


QUESTIONS: tuple[Question, ...] = (
    Question(
        "file",
        _asks_file,
        _reads_file,
        _default_file,
        "The solid model of the crank: STL, STEP, 3MF, OBJ, PLY, GLB and others.",
        keys=("crankshaft.file",),
    ),
    Question(
        "unit",
        _asks_unit,
        _reads_unit,
        _default_unit,
        "STL, OBJ, PLY and OFF store no unit. Take the one in which the size above is that of your crank.",
        applies=lambda talk: needs_unit(file_of(talk)),
        keys=("crankshaft.unit",),
    ),
    Question(
        "material",
        lambda _: ("Material, or density [kg/m³]",),
        _reads_material,
        lambda _: "steel",
        f"One of {', '.join(MATERIALS)}, or a density. Forged steel has 7850, cast iron 7200.",
        applies=lambda talk: not _material_is_known(talk) or "material" in talk.done,
    ),
    Question(
        "recognised",
        _asks_recognised,
        _reads_recognised,
        lambda _: "y",
        "y continues; n shows how to correct it.",
    ),
    Question(
        "rods",
        lambda _: ("The crankpins are wide enough for two rods.", "Rods on each crankpin"),
        _reads_rods,
        lambda _: "2",
        "2 in a vee engine, 1 in an in-line one.",
        applies=_two_rods,
        keys=("engine.rods_per_throw",),
    ),
    Question(
        "old",
        lambda _: ("Was the crank balanced for other parts, such as a heavier piston (y, n)",),
        _reads_old,
        lambda _: "n",
        "y: you enter the old weights too, and can keep the maker's balance factor.",
    ),
    _weight("rotating", ROTATING, "Rotating mass of one rod: big end and its bearing [g]"),
    _weight(
        "reciprocating",
        RECIPROCATING,
        "Reciprocating mass of one rod: small end, piston, wrist pin, rings, clips [g]",
    ),
    _weight("crankpin", PIN, "Crankpin, which is not in the file [g]", applies=_pressed_up),
    _weight("old_rotating", "original.rotating_g.all", "Old rotating mass of one rod [g]", applies=has_old),
    _weight(
        "old_reciprocating",
        "original.reciprocating_g.all",
        "Old reciprocating mass of one rod [g]",
        applies=has_old,
    ),
    _weight(
        "old_crankpin",
        "original.crankpin_g.crankpin",
        "Old crankpin [g]",
        applies=lambda talk: has_old(talk) and _pressed_up(talk),
    ),
    Question(
        "factor",
        _asks_factor,
        _reads_factor,
        _default_factor,
        "The share of the reciprocating mass that the counterweights balance. Singles have 0.25 to 0.65,\n"
        "vee engines 0.5. A factor above the present one needs metal added; one below, metal removed.",
        keys=("balance.factor",),
    ),
    Question(
        "speed",
        lambda _: ("Top speed [rpm]",),
        _number("balance.speed_rpm", "1/min", 1.0, 1e6, "speed"),
        help="The highest speed at which the engine runs. The permissible unbalance falls as it rises.",
        keys=("balance.speed_rpm",),
        may_be_unknown=True,
    ),
    Question(
        "grade",
        lambda _: ("Balance grade G: 6.3 is usual for racing, 16 for road engines, 2.5 is fine",),
        _number("balance.grade", "mm/s", 0.01, 1e4, "grade"),
        lambda _: "6.3",
        "ISO 21940-11 grades: the number is the permissible speed of the centre of mass [mm/s].",
        keys=("balance.grade",),
    ),
    Question(
        "method",
        lambda _: (f"Method of correction ({', '.join(KINDS)}; several with commas)",),
        _reads_method,
        lambda _: "drill",
        "drill: holes in the counterweights; shoulder: mill the web faces; turn: turn the rims;\n"
        "slug: press in heavy metal; mill: pockets; add: weld metal on.",
        keys=("correction.method",),
    ),
)
"""All questions, in their order."""

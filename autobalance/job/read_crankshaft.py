"""The table [crankshaft] of a job, with the keys of a scan."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from autobalance.crank.anatomy import Overrides, PinHint
from autobalance.declare import COUNTED, FILLED, NOT_NEGATIVE, POSITIVE, REQUIRED, Key, Values
from autobalance.errors import JobError
from autobalance.job.model import Calibrate, CrankReadings, Crankshaft, LengthUnit
from autobalance.materials import MATERIALS
from autobalance.runtime import note_read
from autobalance.solid.formats.registry import names_bodies, needs_unit
from autobalance.solid.soundness.holes import OpenHoles
from autobalance.toml_files.keys import read
from autobalance.toml_files.table import convert
from autobalance.units import G_PER_MM3_PER_KG_M3

# Keys of ``[crankshaft]`` for a crank that was scanned: the scanner, a scale, a micrometer.


Vector = tuple[float, float, float]

SCAN = (
    Key(
        "scan_file",
        str,
        "scan of the crank in `file`: mass and unbalance come from the scan, faces and cuts from `file`; the "
        "keys from `scan_accuracy_mm` to `keep_open` then apply to the scan",
        default=None,
        not_empty="must name the file of a scan, relative to the job",
    ),
    Key(
        "scan_unit",
        LengthUnit,
        "length unit of `scan_file`, if its format carries no unit",
        default=None,
        usual="`unit`",
    ),
    Key(
        "scan_accuracy_mm",
        float,
        "scanner accuracy over its full volume, 95 %: error of surface offset and scale; "
        "see [scan.md](scan.md)",
        POSITIVE,
        None,
        usual="the measured roughness",
    ),
    Key("weighed_g", float, "the bare crank on a scale", POSITIVE, None, usual="not weighed"),
    Key("weighed_pm_g", float, "uncertainty of the scale", NOT_NEGATIVE, 0.0),
    Key(
        "calibrate",
        Calibrate,
        'correction for a mass that differs from `weighed_g`: `"skin"`, an even offset of the surface; '
        '`"density"`; `"none"`, the difference is only reported',
        default="none",
    ),
    Key(
        "micrometer_mm",
        None,
        "diameters measured with a micrometer: with `calibrate`, skin and scale of the scan follow from them",
        default=None,
        keys=(
            Key("main_journal", float, "diameter of the main journals", POSITIVE, None, typed="mm"),
            Key("crankpin", float, "diameter of the crankpins", POSITIVE, None, typed="mm"),
        ),
    ),
    Key("micrometer_pm_mm", float, "uncertainty of the micrometer", NOT_NEGATIVE, 0.0),
    Key(
        "fill_holes_mm",
        float,
        "close holes of an open mesh up to this width; 0: such a mesh is refused, with its holes",
        NOT_NEGATIVE,
        0.0,
    ),
    Key(
        "keep_open",
        tuple[Vector, ...],
        "with `fill_holes_mm`: a place at each hole that is a bore, in the file's axes [mm], to be joined to "
        "its other end; empty: none is",
        default=None,
        usual="none; required if a hole may be a bore",
    ),
)


def readings_of(values: Values) -> CrankReadings:
    """Return the measurements of the crank in ``[crankshaft]``.

    Raises
    ------
    JobError If the key to calibrate needs a value that was not measured.
    """
    micrometer = {name: size for name, size in (values["micrometer_mm"] or {}).items() if size is not None}
    weighed, calibrate = values["weighed_g"], values["calibrate"]
    if calibrate == "density" and weighed is None:
        raise JobError('crankshaft.calibrate is "density"; expected weighed_g beside it')
    if calibrate == "skin" and weighed is None and not micrometer:
        raise JobError('crankshaft.calibrate is "skin"; expected weighed_g or micrometer_mm beside it')
    if weighed is None and values["weighed_pm_g"] > 0.0:
        raise JobError("crankshaft.weighed_pm_g needs weighed_g; add it, or remove weighed_pm_g")
    if not micrometer and values["micrometer_pm_mm"] > 0.0:
        raise JobError("crankshaft.micrometer_pm_mm needs micrometer_mm; add it, or remove micrometer_pm_mm")
    return CrankReadings(weighed, values["weighed_pm_g"], calibrate, micrometer, values["micrometer_pm_mm"])


def holes_of(values: Values) -> OpenHoles:
    """Return the holes that ``[crankshaft]`` closes.

    Raises
    ------
    JobError If bores are named but holes are not closed.
    """
    if values["keep_open"] is not None and values["fill_holes_mm"] == 0.0:
        raise JobError("crankshaft.keep_open needs fill_holes_mm; add it, or remove keep_open")
    return OpenHoles(values["fill_holes_mm"], values["keep_open"])


def described_holes(holes: OpenHoles) -> Values:
    """Return the keys that close the same holes; nothing where none are."""
    if holes.fill_mm == 0.0:
        return {}
    keys: Values = {"fill_holes_mm": holes.fill_mm}
    if holes.keep_open is not None:
        keys["keep_open"] = [list(place) for place in holes.keep_open]
    return keys


def described_readings(readings: CrankReadings) -> Values:
    """Return the keys that give the same readings; nothing if nothing was measured."""
    if not readings.any:
        return {}
    keys: Values = {"calibrate": readings.calibrate}
    if readings.weighed_g is not None:
        keys |= {"weighed_g": readings.weighed_g, "weighed_pm_g": readings.weighed_pm_g}
    if readings.micrometer_mm:
        keys["micrometer_mm"] = dict(readings.micrometer_mm)
        keys["micrometer_pm_mm"] = readings.micrometer_pm_mm
    return keys


# The density of a material: a number, or the material's name.


Material: Any = Literal[tuple(MATERIALS)]


def density_keys(of: str, default: Any = REQUIRED) -> tuple[Key, Key]:
    """Return the two keys; their value is the number alone (``typed_units``)."""
    return (
        Key("density_kg_m3", float, f"density of {of}", POSITIVE, default, instead="density"),
        Key(
            "density",
            Material,
            f"material of {of}, in place of the density; `autobalance calc density` lists the sources",
            default=None,
        ),
    )


# The table [crankshaft] of a job.


PIN = (
    Key("centre_mm", Vector, "centre in the file's axes"),
    Key("diameter_mm", float, "diameter", POSITIVE, None),
    Key("width_mm", float, "width of the bare cylinder, between webs or fillets", POSITIVE, None),
)
LEAVE_OUT = "leave it out, or name at least one"
CRANKSHAFT = Key(
    "crankshaft",
    says="the crank's file and how to read it; places and directions in the file's own axes",
    default=FILLED,
    verbs="all",
    keys=(
        Key(
            "file",
            str,
            "crank file, relative to the job file: `.stl .obj .ply .off .3mf .glb .gltf`; "
            "`.step .iges .brep` (`.brp`) with the extra `step`: see [step.md](step.md); "
            "`.dae .3dxml .xaml` with the extra `meshes`",
            not_empty="must name a crank file, relative to the job",
        ),
        Key(
            "unit",
            LengthUnit,
            "length unit of the file; required for STL, OBJ, PLY, OFF and XAML, which store no unit, and for "
            "COLLADA without a unit; in other formats another unit is an error",
            default=None,
        ),
        *density_keys("the crank"),
        Key(
            "density_pm_kg_m3",
            float,
            "uncertainty of the density, 95 %",
            NOT_NEGATIVE,
            None,
            usual="not stated",
        ),
        *SCAN,
        Key(
            "crankpin_in_file",
            bool,
            "`false`: a pressed-up crank without its crankpins, one body for each half",
            default=True,
        ),
        Key("axis_point_mm", Vector, "a point on the crank axis", default=None, usual="recognised"),
        Key("axis_direction", Vector, "direction of the crank axis", default=None, usual="recognised"),
        Key(
            "crankpins",
            None,
            "the crankpins",
            default=None,
            keys=PIN,
            many=True,
            not_empty=LEAVE_OUT,
            usual="recognised",
        ),
        Key(
            "main_journals",
            None,
            "the main journals",
            default=None,
            keys=PIN,
            many=True,
            not_empty=LEAVE_OUT,
            usual="recognised",
        ),
        Key(
            "body",
            int | str,
            "number of the solid, from 1, if the file holds several, or the name of a part in a STEP file; "
            '`"all"` '
            "unites them. A single mesh that overlaps itself is refused with the place and the mass in "
            "doubt; "
            '`"all"` unites it, so that all of its metal counts once',
            COUNTED,
            None,
            not_empty='must be a number, the name of a part, or "all"',
        ),
    ),
)


def of_no_file(key: Key) -> Key:
    """Return ``[crankshaft]`` for a crank that is given as an object: file and density may be missing."""
    free = {"file": None, "density_kg_m3": 0.0}
    keys = tuple(replace(each, default=free[each.name]) if each.name in free else each for each in key.keys)
    return replace(key, keys=keys)


def read_crankshaft(values: Mapping[str, Any], folder: Path) -> Crankshaft:
    """Return the crank of the keys of ``[crankshaft]``; its file is relative to ``folder``.

    Raises
    ------
    JobError
        If a key is unknown, missing, of the wrong type or impossible.
    """
    return crankshaft_of(read({"crankshaft": dict(values)}, (CRANKSHAFT,))["crankshaft"], folder)


def crankshaft_of(values: Values, folder: Path) -> Crankshaft:
    """Return the crank of the table's values; without a file the crank is given as an object.

    Raises
    ------
    JobError
        If they contradict each other.
    """
    file = _file(values["file"], "unit", values["unit"], folder)
    density, off = values["density_kg_m3"], values["density_pm_kg_m3"]
    if file is not None and off is not None and off >= density:
        raise JobError(f"crankshaft.density_pm_kg_m3 is {off:g}; must be < density_kg_m3, {density:g}")
    plain = Crankshaft(
        file,
        values["unit"],
        density * G_PER_MM3_PER_KG_M3,
        _overrides(values),
        None if file is None else _body(values["body"], file),
        None if off is None else off * G_PER_MM3_PER_KG_M3,
    )
    scan = None
    if values["scan_file"] is not None:
        unit = values["scan_unit"] or (values["unit"] if needs_unit(folder / values["scan_file"]) else None)
        there = _file(values["scan_file"], "scan_unit", unit, folder)
        hints = Overrides(crankpin_in_file=values["crankpin_in_file"])
        scan = replace(plain, file=there, unit=unit, overrides=hints, body=None)
    elif values["scan_unit"] is not None:
        raise JobError("crankshaft.scan_unit needs scan_file; add it, or remove scan_unit")
    return replace(plain, scan=scan).weighed_with(
        scan_accuracy_mm=values["scan_accuracy_mm"], readings=readings_of(values), holes=holes_of(values)
    )


def _file(name: str | None, key: str, unit: str | None, folder: Path) -> Path | None:
    """Return the path of a crank file that a job names, with its unit if its format carries no unit."""
    if name is None:
        return None
    file = folder / name
    note_read(file)  # also by what needs only the weights
    if unit is None and needs_unit(file):
        raise JobError(
            f"crankshaft.{key} is missing; {file.suffix.upper()[1:]} carries no unit: one of mm, cm, m, inch"
        )
    return file


def _body(body: int | str | None, file: Path) -> int | str | None:
    if isinstance(body, str) and not names_bodies(file):
        convert(body, int | Literal["all"], "crankshaft.body")
    return body


def _overrides(values: Values) -> Overrides:
    direction, point = values["axis_direction"], values["axis_point_mm"]
    if direction is not None and not any(direction):
        raise JobError("crankshaft.axis_direction is [0, 0, 0]; must point along the crank axis")
    return Overrides(
        axis_point_mm=None if point is None else np.array(point),
        axis_direction=None if direction is None else np.array(direction),
        crankpins=_pins(values["crankpins"]),
        main_journals=_pins(values["main_journals"]),
        crankpin_in_file=values["crankpin_in_file"],
    )


def _pins(pins: list[Values] | None) -> tuple[PinHint, ...] | None:
    if pins is None:
        return None
    return tuple(PinHint(np.array(pin["centre_mm"]), pin["diameter_mm"], pin["width_mm"]) for pin in pins)

"""Keys of ``[crankshaft]`` for a crank that was scanned: the scanner, a scale, a micrometer."""

from __future__ import annotations

from autobalance.declare import NOT_NEGATIVE, POSITIVE, Key, Values
from autobalance.errors import JobError
from autobalance.job.model import LengthUnit
from autobalance.job.model.crank_readings import Calibrate, CrankReadings
from autobalance.solid.soundness.open_holes import OpenHoles

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

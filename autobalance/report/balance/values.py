"""The report as JSON values: every key of the interface, ``None`` where a thing does not apply, never NaN.

Numbers leave in the unit that their key ends with; nothing is computed here but units, lengths and angles.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from autobalance import correction
from autobalance.balancing.record import (
    Balanced,
    MeasuredCrank,
    Record,
    TrueSurfaces,
)
from autobalance.correction.contract import Correction
from autobalance.crank.anatomy import Anatomy
from autobalance.report.balance.crank_values import (
    G_MM2_PER_KG_MM2,
    crank_values,
    degrees,
    face_values,
    mass_properties,
    named_face_values,
    numbers,
    part_values,
    rows,
)
from autobalance.report.balance.relaxation_values import relaxation_values
from autobalance.report.encoding import encoded
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.rigid_rotor.uncertainty import Budget
from autobalance.units import wrapped_deg
from autobalance.version import SCHEMA_VERSION, __version__

if TYPE_CHECKING:
    from autobalance.balancing.external import CarriedUnbalance
    from autobalance.balancing.loop import Result
    from autobalance.report.records import balance as balance_records
    from autobalance.report.records import report as records

LIBRARIES = ("numpy", "scipy", "trimesh", "manifold3d")
STAGES = ("load", "measure", "plan", "cut", "write", "total")

KINDS = ("plane", "cylinder", "cone", "sphere", "torus")

Values = dict[str, Any]
KINDS_OF_CUT = correction.KINDS


def report(record: Record) -> Values:
    """Return the report of a run as JSON values, keys in the order of the interface."""
    balanced = record.balanced
    values: Values = {
        "schema_version": SCHEMA_VERSION,
        "autobalance": {"version": __version__, **library_versions()},
        "command": record.command,
        "job": None if balanced is None else dict(balanced.job),
        **({"job_set": list(balanced.job_set)} if balanced is not None and balanced.job_set else {}),
        "input": {
            "file": record.input.file,
            "sha256": record.input.sha256,
            "format": record.input.format,
            "triangles": record.input.triangles,
            "bodies": record.input.bodies,
            "repairs": list(record.input.repairs),
        },
        "frame": {"file_to_rotor": rows(record.crank.anatomy.file_to_rotor)},
        "crank": crank_values(record.crank),
        "counterweight": _counterweight(balanced),
        "engine": _engine(balanced),
        "balance_factor": _factors(balanced),
        "tolerance": _tolerance(balanced),
        "initial": unbalance_values(
            record.initial, record.planes_z_mm, None if balanced is None else balanced.result.initial_doubt
        ),
        "residual": None,
        "corrections": [],
        "steps": [],
        "inertia_change_kg_mm2": None,
        "forces": None if balanced is None else _forces(balanced),
        "outcome": None,
        "proven": None,
        "reason": None,
        "overbalance": None,
        "warnings": list(record.warnings),
        "outputs": dict(record.outputs),
        "seconds": {stage: record.seconds.get(stage) for stage in STAGES},
    }
    if balanced is not None:
        values |= _result(balanced, record)
    if balanced is not None and balanced.loads_with_gas is not None:
        values["loads_with_gas"] = encoded(balanced.loads_with_gas)
    if balanced is not None and balanced.external:
        values["external"] = [external_values(each) for each in balanced.external]
    if balanced is not None and balanced.assembly:
        from autobalance.report.balance.assembly_values import assembly_values

        values["assembly"] = assembly_values(balanced.assembly, record.planes_z_mm, unbalance_values)
    values |= record.staged
    if record.surfaces is not None:
        values["true_surfaces"] = _true_surfaces(record.surfaces, balanced)
    if record.faces is not None:
        values["faces"] = [face_values(offer, record.crank.anatomy) for offer in record.faces]
    if record.sections is not None:
        values["sections"] = [part_values(part) for part in record.sections]
    if record.web_weights is not None:
        values["counterweights"] = [
            {
                "web": weight.web,
                "mass_g": weight.mass_g,
                "radius_mm": weight.radius_mm,
                "product_g_mm": weight.product_g_mm,
            }
            for weight in record.web_weights
        ]
    return values


def external_values(carried: CarriedUnbalance) -> records.ExternalPart:
    """Return what an external part is to carry."""
    x, y = carried.unbalance_g_mm
    return {
        "name": carried.part.name,
        "z_mm": carried.part.z_mm,
        "unbalance_g_mm": numbers(carried.unbalance_g_mm),
        "magnitude_g_mm": math.hypot(x, y),
        "angle_deg": wrapped_deg(math.degrees(math.atan2(y, x))),
        "change_g_mm": numbers(carried.unbalance_g_mm - np.array(carried.part.unbalance_g_mm)),
        "pm_g_mm": carried.pm_g_mm,
    }


def _true_surfaces(before: TrueSurfaces, balanced: Balanced | None) -> records.TrueSurfaces:
    written = None if balanced is None else balanced.result.measured
    after = None
    if written is not None and written.surfaces is not None and written.hidden is not None:
        after = _surfaces(written.surfaces, written.hidden)
    return {"before": _surfaces(before.faces, before.hidden), "after": after}


def _surfaces(faces: Mapping[str, int], hidden: Moments) -> records.SurfacesOfSolid:
    """Faces by kind, and what they hold more than triangles laid over them."""
    return {
        "faces": {
            "plane": faces.get("plane", 0),
            "cylinder": faces.get("cylinder", 0),
            "cone": faces.get("cone", 0),
            "sphere": faces.get("sphere", 0),
            "torus": faces.get("torus", 0),
            "other": sum(number for kind, number in faces.items() if kind not in KINDS),
        },
        "facets_hide": {"mass_g": hidden.mass_g, "unbalance_g_mm": numbers(hidden.first_g_mm[:2])},
    }


def generate_report(
    design: Mapping[str, Any], crank: MeasuredCrank, engine: Mapping[str, Any] | None, solid: Values
) -> Values:
    """Return what ``generate`` says of the crank it built: dimensions in, mass properties out."""
    return {
        "schema_version": SCHEMA_VERSION,
        "autobalance": {"version": __version__, **library_versions()},
        "command": "generate",
        "design": dict(design),
        "frame": {"file_to_rotor": rows(crank.anatomy.file_to_rotor)},
        "crank": crank_values(crank),
        "initial": unbalance_values(Unbalance.of(crank.moments), None, None),
        "engine": None if engine is None else dict(engine),
        "outputs": {"solid": solid},
    }


def dumps(values: Mapping[str, Any]) -> str:
    """Return a report as JSON text; raises ValueError for NaN and infinity.

    Bytes of a file's name that are no UTF-8 stand as JSON's escapes of lone surrogates, and read back so.
    """
    text = json.dumps(values, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    return text.encode("utf-8", "backslashreplace").decode()


def showable(values: Values) -> Values:
    """Return a report for pages: a question mark for what is no text in the names of files."""
    text = json.dumps(values, ensure_ascii=False)
    shown = text.encode("utf-8", "replace").decode()
    found: Values = values if shown == text else json.loads(shown)
    return found


def schema(of: Literal["report", "generate"] = "report") -> Values:
    """Return the JSON Schema (draft 2020-12) of reports, or of what ``generate`` says."""
    from autobalance.report.records.written import written_schema

    return written_schema(of)


def solid_entry(
    file: str, sha256: str | None, triangles: int | None, moments: Moments, volume_mm3: float
) -> Values:
    """Return the entry of a written solid in ``outputs``, with what is claimed of it (rotor frame)."""
    return {"file": file, "sha256": sha256, "triangles": triangles, **mass_properties(moments, volume_mm3)}


@cache
def library_versions() -> dict[str, str | None]:
    """Return the version of each library that is installed; looking them up reads files."""
    from importlib.metadata import PackageNotFoundError, version

    found: dict[str, str | None] = {}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = None
    return found


# --- weights and limits -------------------------------------------------------------------------------------


def _counterweight(balanced: Balanced | None) -> balance_records.Counterweight | None:
    if balanced is None or balanced.counterweight is None:
        return None
    found = balanced.counterweight
    return {
        "mass_g": found.mass_g,
        "radius_mm": found.initial_g_mm / found.mass_g,
        "product_g_mm": {
            "initial": found.initial_g_mm,
            "target": found.target_g_mm,
            "final": found.final_g_mm,
        },
    }


def _engine(balanced: Balanced | None) -> balance_records.Engine | None:
    if balanced is None:
        return None
    loads = balanced.loads
    return {
        "rotating_g": loads.rotating_g,
        "reciprocating_g": loads.reciprocating_g,
        "crankpin_g": loads.crankpin_g,
        "bob_weights": [
            {
                "throw": number,
                "mass_g": mass,
                "fit_g": loads.fit_g[number],
                "tolerance_g": loads.tolerance_g,
            }
            for number, mass in sorted(loads.bob_weights_g.items())
        ],
    }


def _factors(balanced: Balanced | None) -> balance_records.BalanceFactor | None:
    if balanced is None:
        return None
    factors = balanced.factors
    return {"initial": factors.initial, "target": factors.target, "final": factors.final}


def _tolerance(balanced: Balanced | None) -> balance_records.Tolerance | None:
    return None if balanced is None else tolerance_values(balanced.tolerance, balanced.job)


def tolerance_values(tolerance: Tolerance, job: Mapping[str, Any]) -> balance_records.Tolerance:
    """Return what a residual is judged against; ``job`` as the report describes it."""
    return {
        "grade_mm_s": tolerance.grade_mm_s,
        "speed_rpm": job["balance"]["speed_rpm"],  # as given, without the rounding of conversion
        "rotor_mass_g": tolerance.rotor_mass_g,
        "permissible_g_mm": tolerance.permissible_g_mm,
        "planes": [
            {"name": plane.name, "z_mm": plane.z_mm, "permissible_g_mm": plane.permissible_g_mm}
            for plane in tolerance.planes
        ],
        "judge": tolerance.judge,
        "margin": tolerance.margin,
    }


def _forces(balanced: Balanced) -> Values | None:
    forces = balanced.forces
    if forces is None:
        return None
    from autobalance.report.records.forces import ShakingForce

    return {
        "speed_rpm": balanced.job["balance"]["speed_rpm"],
        "before": encoded(ShakingForce.of(forces.before, all_orders=forces.all_orders)),
        "after": encoded(ShakingForce.of(forces.after, all_orders=forces.all_orders)),
    }


# --- before and after ---------------------------------------------------------------------------------------


def unbalance_values(
    unbalance: Unbalance, planes_z_mm: tuple[float, float] | None, doubt: Budget | None
) -> Values:
    """Return an unbalance with its vectors in two planes, and how far they may be off."""
    vectors = np.zeros((0, 2)) if planes_z_mm is None else unbalance.in_planes(*planes_z_mm)
    in_planes = (None, None) if doubt is None or not doubt.total.planes_g_mm else doubt.total.planes_g_mm
    return {
        "unbalance_g_mm": numbers(unbalance.resultant_g_mm),
        "magnitude_g_mm": unbalance.magnitude_g_mm,
        "angle_deg": degrees(unbalance.angle_rad),
        "planes": [
            {
                "name": name,
                "unbalance_g_mm": numbers(vector),
                "magnitude_g_mm": math.hypot(*vector),
                "uncertainty_g_mm": in_planes[place],
                "uncertainty_shares_g_mm": None
                if doubt is None
                else {cause: share.planes_g_mm[place] for cause, share in doubt.shares.items()},
            }
            for place, (name, vector) in enumerate(zip("AB", vectors, strict=False))
        ],
        "moment_g_mm2": numbers(unbalance.moment_g_mm2),
        "uncertainty_g_mm": None if doubt is None else doubt.total_g_mm,
        "uncertainty_shares_g_mm": None
        if doubt is None
        else {cause: share.resultant_g_mm for cause, share in doubt.shares.items()},
        "uncertainty_unstated": None if doubt is None else list(doubt.unstated),
    }


def _result(balanced: Balanced, record: Record) -> Values:
    result = balanced.result
    change = result.final_moments.polar_inertia_g_mm2 - result.initial_moments.polar_inertia_g_mm2
    return {
        "residual": unbalance_values(result.residual, record.planes_z_mm, result.doubt),
        "corrections": [
            correction_entry(number, each, record.crank.anatomy)
            for number, each in enumerate(result.corrections, record.cuts_before + 1)
        ],
        "faces": [named_face_values(face, record.crank.anatomy) for face in balanced.faces],
        "steps": [
            {
                "step": step.step,
                "depths_mm": numbers(step.depths_mm),
                "predicted_g_mm": step.predicted_g_mm,
                "measured_g_mm": step.measured_g_mm,
            }
            for step in result.steps
        ],
        "inertia_change_kg_mm2": change / G_MM2_PER_KG_MM2,
        "outcome": result.outcome,
        "proven": balanced.tolerance.is_proven_by(result.residual, result.doubt),
        "reason": result.reason,
        "relaxations": [relaxation_values(each) for each in result.relaxations],
        "notes": list(result.notes),
        "overbalance": _overbalance(balanced, record.crank.anatomy),
        **_with_slugs(result),
    }


def _with_slugs(result: Result) -> Values:
    """Return mass and centre with what is pressed in, where anything is: the written solid lacks it."""
    if result.measured is None or not any(
        correction.KINDS[each.kind].pressed_in for each in result.corrections
    ):
        return {}
    final = result.final_moments
    return {"final_with_slugs": {"mass_g": final.mass_g, "centre_of_mass_mm": numbers(final.centre_mm)}}


def _overbalance(balanced: Balanced, anatomy: Anatomy) -> Values | None:
    left = balanced.overbalance
    if left is None:
        return None
    return {
        "unbalance_g_mm": numbers(left.unbalance.resultant_g_mm),
        "magnitude_g_mm": left.unbalance.magnitude_g_mm,
        "angle_deg": degrees(left.unbalance.angle_rad),
        "last_holes": [correction_entry(number, each, anatomy) for number, each in enumerate(left.holes, 1)],
        "predicted_g_mm": None if left.predicted is None else left.predicted.magnitude_g_mm,
        "reason": left.reason,
    }


def correction_entry(number: int, correction: Correction, anatomy: Anatomy) -> Values:
    """Return what the report lists of a correction: what all have, the kind's own details, its place."""
    rate, back = correction.rate, anatomy.rotor_to_file
    axis = None if correction.axis is None else numbers(back[:3, :3] @ correction.axis)
    item = {"face": correction.face, **correction.details}
    return {
        "kind": correction.kind,
        "number": number,
        "label": f"cut {number}: {KINDS_OF_CUT[correction.kind].label(item)}",
        "face": correction.face,
        "web": correction.web,
        "position_mm": numbers(correction.position_mm),
        "radius_mm": math.hypot(*correction.change.centre_mm[:2]),
        "depth_mm": float(correction.depth_mm),
        "removed_mass_g": -correction.change.mass_g,
        "removed_volume_mm3": float(correction.removed_volume_mm3),
        "unbalance_change_g_mm": numbers(correction.change.first_g_mm[:2]),
        "unbalance_per_mm_g_mm": None if rate is None else numbers(rate.first_g_mm[:2]),
        "moment_per_mm_g_mm2": None if rate is None else numbers(rate.second_g_mm2[:2, 2]),
        "tool_volume_mm3": float(correction.tool_volume_mm3),
        "file_position_mm": numbers(back[:3, :3] @ correction.position_mm + back[:3, 3]),
        "file_axis": axis,
        **correction.details,
        "angle_deg": degrees(math.atan2(correction.position_mm[1], correction.position_mm[0])),
        "z_mm": float(correction.position_mm[2]),
    }

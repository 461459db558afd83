"""A job as plain values for the report: as read, in the job file's own words, defaults filled in."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from autobalance.crank.anatomy import PinHint
from autobalance.job.model import (
    BalanceShaftEntry,
    CylinderLayout,
    PartWeights,
    RodOnScales,
    ThrowParts,
    Weight,
)
from autobalance.job.read import Job
from autobalance.units import G_MM2_PER_KG_MM2, G_PER_MM3_PER_KG_M3, RAD_S_PER_RPM

if TYPE_CHECKING:
    from autobalance.signal.drive_sources import Drive


def describe(job: Job) -> dict[str, Any]:
    """Return the job as JSON values; None where an optional key was not given.

    Everything has the units of the job file, so that ``parse`` takes it back once ``file`` and the Nones are
    dropped.
    """
    balance = job.balance
    return {
        "file": str(job.path.resolve()),
        "crankshaft": _crankshaft(job),
        "engine": _engine(job),
        "original": None if job.original is None else _weights(job.original),
        "balance": {
            "factor": "original" if balance.factor is None else balance.factor,
            "grade": balance.grade_mm_s,
            "speed_rpm": _as_given(job, "speed_rpm", balance.service_speed_rad_s / RAD_S_PER_RPM),
            "judge": balance.judge,
            "margin": balance.margin,
            "facet_correction": balance.facet_correction,
            "rotor_mass_g": balance.rotor_mass_g,
            "tolerance_planes_mm": _listed(balance.tolerance_planes_mm),
            "overbalance_g_mm": balance.overbalance_g_mm,
            "overbalance_deg": _as_given(job, "overbalance_deg", math.degrees(balance.overbalance_rad)),
        },
        **({"cycle": dict(job.cycle.values)} if job.cycle is not None else {}),
        **({"shafts": [_shaft(shaft) for shaft in job.shafts]} if job.shafts else {}),
        **({} if job.torsion is None else job.torsion.filled),
        **({"study": asdict(job.study)} if "study" in job.raw else {}),
        **({} if job.drive is None else {"drive": _drive(job.drive)}),
        **({"assembly": [dict(each.values) for each in job.assembly]} if job.assembly else {}),
        "correction": {
            "method": list(job.method_names),
            "prefer": job.prefer,
            "depth_tolerance_mm": job.depth_tolerance_mm,
            **{
                name: {key: _plain(value) for key, value in asdict(limits).items()}
                for name, limits in zip(job.method_names, job.methods, strict=True)
            },
        },
    }


def _drive(drive: Drive) -> dict[str, Any]:
    return {
        "gear": [asdict(each) for each in drive.gears],
        "belt": [asdict(each) for each in drive.belts],
        "shaft": [asdict(each) for each in drive.shafts],
    }


def _as_given(job: Job, key: str, value: float) -> float:
    """Return the number of ``[balance]`` as the file has it, without the rounding of its conversion."""
    return float(job.raw.get("balance", {}).get(key, value))


def _crankshaft(job: Job) -> dict[str, Any]:
    crank, hints = job.crankshaft, job.crankshaft.overrides
    return {
        "file": job.raw.get("crankshaft", {}).get("file", None if crank.file is None else str(crank.file)),
        "unit": crank.unit,
        "density_kg_m3": float(
            job.raw.get("crankshaft", {}).get("density_kg_m3", crank.density_g_mm3 / G_PER_MM3_PER_KG_M3)
        ),
        "density_pm_kg_m3": None
        if crank.density_pm_g_mm3 is None
        else float(
            job.raw.get("crankshaft", {}).get(
                "density_pm_kg_m3", crank.density_pm_g_mm3 / G_PER_MM3_PER_KG_M3
            )
        ),
        "crankpin_in_file": crank.crankpin_in_file,
        "axis_point_mm": _listed(hints.axis_point_mm),
        "axis_direction": _listed(hints.axis_direction),
        "crankpins": None if hints.crankpins is None else [_pin(pin) for pin in hints.crankpins],
        "main_journals": None if hints.main_journals is None else [_pin(pin) for pin in hints.main_journals],
        "body": crank.body,
    }


def _pin(pin: PinHint) -> dict[str, Any]:
    return {
        "centre_mm": _listed(pin.centre_mm),
        "diameter_mm": pin.diameter_mm,
        "width_mm": pin.width_mm,
    }


def _engine(job: Job) -> dict[str, Any]:
    engine = job.engine
    return {
        "rod_length_mm": engine.rod_length_mm,
        "stroke_mm": engine.stroke_mm,
        **({"layout": _layout(engine.layout)} if engine.layout != CylinderLayout() else {}),
        **({"rod": _rod(engine.rod)} if engine.rod is not None else {}),
        "rods_per_throw": engine.default.rods,
        **_weights(engine.default.weights),
        "throw": [_throw(number, parts, engine.layout) for number, parts in sorted(engine.by_throw.items())],
        "attached": [
            {
                "name": item.name,
                "mass_g": item.mass_g,
                "unbalance_g_mm": list(item.unbalance_g_mm),
                "z_mm": item.z_mm,
                **({"pm_g_mm": item.pm_g_mm} if item.pm_g_mm else {}),
            }
            for item in engine.attached
        ],
    }


def _throw(number: int, parts: ThrowParts, layout: CylinderLayout) -> dict[str, Any]:
    banks = layout.bank_by_throw.get(number)
    own = {} if banks is None else {"bank_deg": _degrees(banks)}
    return {"number": number, "rods": parts.rods, **own, **_weights(parts.weights)}


def _layout(layout: CylinderLayout) -> dict[str, Any]:
    return {
        "bank_deg": None if layout.bank_rad is None else _degrees(layout.bank_rad),
        "rod_pitch_mm": layout.rod_pitch_mm,
        "offset_mm": layout.offset_mm,
    }


def _degrees(angles_rad: Sequence[float]) -> list[float]:
    return [math.degrees(angle) for angle in angles_rad]


def _rod(rod: RodOnScales) -> dict[str, Any]:
    inertia = rod.inertia_g_mm2
    return {
        "big_end_g": rod.big_end_g,
        "small_end_g": rod.small_end_g,
        "inertia_kg_mm2": None if inertia is None else inertia / G_MM2_PER_KG_MM2,
        **({"solid": dict(rod.solid)} if rod.solid else {}),
    }


def _shaft(shaft: BalanceShaftEntry) -> dict[str, Any]:
    product: dict[str, Any] = {"weight": [asdict(item) for item in shaft.weights]}
    return {
        "order": shaft.order,
        "sense": "forward" if shaft.forward else "backward",
        "phase_deg": math.degrees(shaft.phase_rad),
        "place_mm": list(shaft.place_mm),
        "z_mm": shaft.z_mm,
        **(product if shaft.weights else {"product_g_mm": shaft.product_g_mm}),
    }


def _weights(weights: PartWeights) -> dict[str, Any]:
    return {
        "rotating_g": {name: _weight(weight) for name, weight in weights.rotating.items()},
        "reciprocating_g": {name: _weight(weight) for name, weight in weights.reciprocating.items()},
        "crankpin_g": {name: _weight(weight) for name, weight in weights.crankpin.items()},
    }


def _weight(weight: Weight) -> float | dict[str, float | str]:
    if weight.distribution is not None:
        return {"g": weight.mass_g, "pm": weight.pm_g, "distribution": weight.distribution}
    return {"g": weight.mass_g, "pm": weight.pm_g} if weight.pm_g else weight.mass_g


def _listed(values: Any) -> list[float] | None:
    return None if values is None else [float(value) for value in values]


def _plain(value: Any) -> Any:
    return [_plain(item) for item in value] if isinstance(value, tuple) else value

"""What a report says of a crank."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from autobalance.balancing.record import (
    ChordalErrorEntry,
    FaceOffer,
    MeasuredCrank,
)
from autobalance.crank.anatomy import Anatomy, Face, MainJournal, Pin, Throw, Web
from autobalance.crank.scan import ScanFit, ScannedCylinder
from autobalance.crank.sections import Section
from autobalance.machine_models.scan_calibration import Calibration
from autobalance.report.balance.datum_values import datum_values
from autobalance.rigid_rotor.moments import Moments
from autobalance.types import Array
from autobalance.units import G_PER_MM3_PER_KG_M3, wrapped_deg

if TYPE_CHECKING:
    from autobalance.report.records import crank as crank_records
    from autobalance.report.records import report as records

G_MM2_PER_KG_MM2 = 1000.0


def numbers(values: Iterable[float]) -> list[float]:
    """Return plain numbers."""
    return [float(value) for value in values]


def rows(matrix: Array) -> list[list[float]]:
    """Return a matrix as lists of plain numbers."""
    return [numbers(row) for row in matrix]


def degrees(angle_rad: float) -> float:
    """Return an angle in [0, 360)."""
    return wrapped_deg(math.degrees(angle_rad))


def part_values(part: Section) -> records.Section:
    """Return a part of the crank with its mass and products."""
    moments = part.moments
    return {
        "kind": part.kind,
        "number": part.number,
        "mass_g": moments.mass_g,
        "centre_mm": numbers(moments.centre_mm),
        "unbalance_g_mm": numbers(moments.first_g_mm[:2]),
        "moment_g_mm2": numbers(moments.second_g_mm2[:2, 2]),
    }


def _outline(web: Web) -> crank_records.WebOutline | None:
    if web.outline is None:
        return None
    return {
        "rim_radius_mm": web.outline.rim_radius_mm,
        "fan_angle_deg": min(math.degrees(web.outline.fan_angle_rad), 360.0),
        "thickness_mm": web.outline.thickness_mm,
        "skew_deg": math.degrees(web.outline.skew_rad),
    }


def mass_properties(moments: Moments, volume_mm3: float) -> crank_records.MassProperties:
    """Return mass, volume, centre and inertia of a body in the rotor frame."""
    return {
        "mass_g": moments.mass_g,
        "volume_mm3": volume_mm3,
        "centre_of_mass_mm": numbers(moments.centre_mm),
        "inertia_kg_mm2": rows(moments.inertia_g_mm2 / G_MM2_PER_KG_MM2),
        "polar_inertia_kg_mm2": moments.polar_inertia_g_mm2 / G_MM2_PER_KG_MM2,
    }


def crank_values(crank: MeasuredCrank) -> crank_records.Crank:
    """Return what was measured and recognised."""
    anatomy, error = crank.anatomy, crank.facet_error
    body = mass_properties(crank.moments, crank.volume_mm3)
    values: crank_records.Crank = {
        "mass_g": body["mass_g"],
        "volume_mm3": body["volume_mm3"],
        "centre_of_mass_mm": body["centre_of_mass_mm"],
        "inertia_kg_mm2": body["inertia_kg_mm2"],
        "polar_inertia_kg_mm2": body["polar_inertia_kg_mm2"],
        "main_journals": [_journal(pin, anatomy.scan) for pin in anatomy.main_journals],
        "throws": [_throw(throw, anatomy.scan) for throw in anatomy.throws],
        "webs": [
            {
                "number": web.number,
                "z_min_mm": float(web.z_min_mm),
                "z_max_mm": float(web.z_max_mm),
                "counterweight": bool(web.counterweight),
                "outline": _outline(web),
            }
            for web in anatomy.webs
        ],
        "journal_misalignment_mm": float(anatomy.journal_misalignment_mm),
        "facet_error": None if error is None else _facet_error(error),
        "datums": None if anatomy.datums is None else datum_values(anatomy.datums),
    }
    if anatomy.scan is not None:
        values["roughness_mm"] = anatomy.scan.roughness_mm
        values["axis_uncertainty"] = {
            "offset_mm": anatomy.scan.axis_offset_mm,
            "angle_deg": anatomy.scan.axis_angle_deg,
        }
    if crank.calibration is not None:
        values["calibration"] = _calibration(crank.calibration)
    return values


def _calibration(calibration: Calibration) -> crank_records.Calibration:
    return {
        "by": calibration.by,
        "skin_mm": calibration.skin_mm,
        "skin_pm_mm": calibration.skin_pm_mm,
        "scale": calibration.scale,
        "scale_pm": calibration.scale_pm,
        "density_kg_m3": calibration.density_g_mm3 / G_PER_MM3_PER_KG_M3,
        "mass_difference_g": calibration.mass_difference_g,
        "contradictions": list(calibration.contradictions),
    }


def _journal(pin: MainJournal, scan: ScanFit | None) -> crank_records.Journal:
    values: crank_records.Journal = {
        "number": pin.number,
        "centre_mm": numbers(pin.centre_mm),
        "diameter_mm": float(pin.diameter_mm),
        "width_mm": float(pin.width_mm),
    }
    if scan is None:
        return values
    each = scan.journals[pin.number - 1]
    values["diameter_pm_mm"] = each.diameter_pm_mm
    values["rms_mm"] = each.rms_mm
    values["out_of_round_mm"] = each.out_of_round_mm
    values["journal_run_out_mm"] = float(each.run_out_mm or 0.0)
    return values


def _scanned_pin(pin: Pin, each: ScannedCylinder) -> crank_records.Pin:
    return {
        **_pin(pin),
        "diameter_pm_mm": each.diameter_pm_mm,
        "rms_mm": each.rms_mm,
        "out_of_round_mm": each.out_of_round_mm,
    }


def _facet_error(error: ChordalErrorEntry) -> crank_records.FacetError:
    needed, added = error.needed, error.added
    return {
        "mass_g": error.mass_g,
        "unbalance_g_mm": error.unbalance_g_mm,
        "mass_bar_g": error.mass_bar_g,
        "unbalance_bar_g_mm": error.unbalance_bar_g_mm,
        "sag_mm": error.sag_mm,
        "correction": error.correction,
        "reason": error.reason,
        "added": None if added is None else {"before": _added(added[0]), "after": _added(added[1])},
        "too_coarse": None
        if needed is None
        else {"finer": needed.finer, "needed_sag_mm": needed.sag_mm, "text": needed.text},
    }


def _added(moments: Moments) -> crank_records.HiddenMetal:
    return {
        "mass_g": moments.mass_g,
        "unbalance_g_mm": numbers(moments.first_g_mm[:2]),
        "moment_g_mm2": numbers(moments.second_g_mm2[:2, 2]),
        "polar_inertia_kg_mm2": moments.polar_inertia_g_mm2 / G_MM2_PER_KG_MM2,
    }


def _pin(pin: Pin) -> crank_records.Pin:
    return {
        "centre_mm": numbers(pin.centre_mm),
        "diameter_mm": float(pin.diameter_mm),
        "width_mm": float(pin.width_mm),
    }


def _throw(throw: Throw, scan: ScanFit | None) -> crank_records.Throw:
    place = throw.number - 1
    values: crank_records.Throw = {
        "number": throw.number,
        "crank_radius_mm": float(throw.crank_radius_mm),
        "angle_deg": degrees(throw.angle_rad),
        "crankpin": _pin(throw.crankpin),
    }
    if scan is not None:
        values["crankpin"] = _scanned_pin(throw.crankpin, scan.crankpins[place])
        values["crank_radius_pm_mm"] = scan.crank_radius_pm_mm[place]
        values["angle_pm_deg"] = scan.angle_pm_deg[place]
    return values


def face_values(offer: FaceOffer, anatomy: Anatomy) -> records.Face:
    """Return a face that a correction can use."""
    return {
        **named_face_values(offer.face, anatomy),
        "unbalance_per_mm_g_mm": numbers(offer.unbalance_per_mm_g_mm),
        "max_depth_mm": offer.max_depth_mm,
    }


def named_face_values(face: Face, anatomy: Anatomy) -> records.NamedFace:
    """Return a face of the crank."""
    back = anatomy.rotor_to_file
    return {
        "id": face.id,
        "kind": face.kind,
        "web": face.web,
        "area_mm2": float(face.area_mm2),
        "normal": numbers(face.normal),
        "centroid_mm": numbers(face.centroid_mm),
        "file_centroid_mm": numbers(back[:3, :3] @ face.centroid_mm + back[:3, 3]),
    }

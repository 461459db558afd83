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
from autobalance.crank.anatomy import Anatomy, Face, Pin, Throw, Web
from autobalance.crank.sections import Section
from autobalance.report.balance.datum_values import datum_values
from autobalance.rigid_rotor.moments import Moments
from autobalance.types import Array
from autobalance.units import wrapped_deg

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
    return {
        **mass_properties(crank.moments, crank.volume_mm3),
        "main_journals": [{"number": pin.number, **_pin(pin)} for pin in anatomy.main_journals],
        "throws": [_throw(throw) for throw in anatomy.throws],
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


def _throw(throw: Throw) -> crank_records.Throw:
    return {
        "number": throw.number,
        "crank_radius_mm": float(throw.crank_radius_mm),
        "angle_deg": degrees(throw.angle_rad),
        "crankpin": _pin(throw.crankpin),
    }


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

"""Doubts of what is typed: values that the file contradicts, a unit that makes no crank."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from autobalance.balancing.rotor_from_job import default_planes_mm, hung_on, target_factor, tolerance_of
from autobalance.crank.anatomy import Anatomy, AxisFound, CylinderFound
from autobalance.crank.recognition.typed import SAME_DIAMETER_MM, SAME_DIAMETER_SHARE
from autobalance.errors import JobError
from autobalance.job import Job
from autobalance.job.model import Crankshaft
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.solid.formats.read import Source
from autobalance.types import Array
from autobalance.units import MM_PER
from autobalance.value_classes import dataclass

# Warnings of a typed axis, journal or crankpin that the file contradicts, with the unbalance at stake.
#
# The unbalance is that of the crank with its bob-weights, once about the typed axis or crankpin and once
# about the one in the file.


@dataclass(frozen=True, eq=False)
class _Rotor:
    """The crank with its bob-weights, as far as a job states them.

    ``bob_weights_g`` are those of the throws, None without a job; ``tolerance`` None likewise.
    """

    moments: Moments
    bob_weights_g: tuple[float, ...] | None
    tolerance: Tolerance | None

    @classmethod
    def of(cls, anatomy: Anatomy, crank: Moments, job: Job | None) -> _Rotor:
        if job is None:
            return cls(crank, None, None)
        try:
            factor = target_factor(job, anatomy, crank)
            loads, attached = hung_on(job, anatomy)
            bobs = tuple(load.parts.bob_weight_g(factor) for load in loads)
            whole = crank + attached
            for throw, bob in zip(anatomy.throws, bobs, strict=True):
                whole = whole + Moments.point(bob, throw.crankpin.centre_mm)
            return cls(whole, bobs, tolerance_of(job, anatomy, crank))
        except JobError:  # reported in its own place
            return cls(crank, None, None)

    def share(self, unbalance_g_mm: float) -> str:
        """Return an unbalance and its share of the permissible value, in words."""
        text = f"{unbalance_g_mm:.3g} g·mm"
        if self.tolerance is None:
            return text
        permissible = self.tolerance.permissible_g_mm
        times = unbalance_g_mm / permissible
        share = f"{times:.2g} times" if times >= 1.0 else f"{100.0 * times:.2g} % of"
        return f"{text}, {share} the permissible {permissible:.4g} g·mm"

    def about(self, line: AxisFound) -> float:
        """Return the change of the unbalance [g·mm] if the rotor turns about another line."""
        z = float(self.moments.centre_mm[2])
        return self.moments.mass_g * float(np.hypot(*line.at(z)))


def typed_warnings(anatomy: Anatomy, crank: Moments, job: Job | None = None) -> tuple[str, ...]:
    """Return a warning for each typed value that the file contradicts, and for each cylinder left out.

    Parameters
    ----------
    anatomy : Anatomy
    crank : Moments
        Of the bare crank, rotor frame.
    job : Job or None
        Its weights and tolerance, from which the share of the permissible value is.
    """
    typed = anatomy.typed
    if not (typed.is_axis or typed.main_journals or typed.crankpins):
        return ()
    rotor = _Rotor.of(anatomy, crank, job)
    return (
        *_axis(anatomy, rotor, job is not None),
        *_journals(anatomy, rotor),
        *_crankpins(anatomy, rotor),
        *typed.left_out,
    )


def _axis(anatomy: Anatomy, rotor: _Rotor, is_job: bool) -> Iterator[str]:
    typed = anatomy.typed
    line = typed.axis
    if line is None or not line.offset_mm > line.within_mm:
        return
    keys = [("axis_point_mm", "--axis-point", typed.axis_point)]
    keys += [("axis_direction", "--axis-direction", typed.axis_direction)]
    named = " and ".join(key if is_job else f"{key} ({option})" for key, option, is_typed in keys if is_typed)
    at = _in_file(anatomy, np.array([*line.at(line.z_mm), line.z_mm]))
    yield (
        f"{named}: the typed axis is {line.offset_mm:.3g} mm off the main journals in the file (⌀"
        f"{line.diameter_mm:.4g} mm, agreement within {line.within_mm:.2g} mm expected): "
        f"{rotor.share(rotor.about(line))}. The axis of the file passes through {_point(at)} mm"
    )


def _journals(anatomy: Anatomy, rotor: _Rotor) -> Iterator[str]:
    """Compare each typed main journal: the axis follows it unless that was typed, the planes always."""
    typed = anatomy.typed
    for number, found in enumerate(typed.main_journals or ()):
        if found is None:
            continue
        name = f"main_journals[{found.hint}]"
        if found.offset_mm > found.within_mm:
            meaning = "the typed axis decides"
            if not typed.is_axis:
                meaning = rotor.share(rotor.about(_moved_axis(typed.main_journals or (), number)))
            yield _off(name, found, found.offset_mm, "across the axis", meaning)
        if abs(found.along_mm) > found.within_mm:
            yield _off(
                name, found, abs(found.along_mm), "along the axis", _in_moved_plane(anatomy, rotor, number)
            )
        yield from _other_diameter(name, found)


def _moved_axis(journals: tuple[CylinderFound | None, ...], number: int) -> AxisFound:
    """Return the axis if one typed journal alone were where the file has it."""
    here = [each for each in journals if each is not None]
    moved = journals[number]
    centres = np.array([each.centre_mm if each is moved else each.typed_mm for each in here])
    return AxisFound(centres, 0.0, 0.0)


def _in_moved_plane(anatomy: Anatomy, rotor: _Rotor, number: int) -> str:
    """Return the change of the initial unbalance in a tolerance plane that is at a journal, in words."""
    tolerance, found = rotor.tolerance, (anatomy.typed.main_journals or ())[number]
    planes = default_planes_mm(anatomy)
    if planes is None or found is None:
        return "0 g·mm; the bearing's load changes"
    if tolerance is not None and tolerance.places_mm != planes:
        return "0 g·mm in the tolerance planes, which the job sets; the bearing's load changes"
    journals = list(anatomy.main_journals)
    journals[number] = replace(journals[number], centre_mm=found.centre_mm)
    there = default_planes_mm(replace(anatomy, main_journals=tuple(journals)))
    if there is None or there == planes or there[0] == there[1]:
        return "0 g·mm in the tolerance planes; the bearing's load changes"
    unbalance = Unbalance.of(rotor.moments)
    change = np.linalg.norm(unbalance.in_planes(*there) - unbalance.in_planes(*planes), axis=1)
    worst = int(np.argmax(change))
    text = f"{change[worst]:.3g} g·mm of the initial unbalance in plane {'AB'[worst]}"
    if tolerance is None:
        return text
    least = tolerance.planes[worst].permissible_g_mm
    return f"{text}, {change[worst] / least:.2g} times the permissible {least:.4g} g·mm"


def _crankpins(anatomy: Anatomy, rotor: _Rotor) -> Iterator[str]:
    for number, found in enumerate(anatomy.typed.crankpins or ()):
        if found is None:
            continue
        name, throw = f"crankpins[{found.hint}]", anatomy.throws[number]
        if found.offset_mm > found.within_mm:
            radius = math.hypot(*found.centre_mm[:2])
            meaning = [f"crank radius {throw.crank_radius_mm:.5g} mm typed, {radius:.5g} mm in the file"]
            meaning.append(_of_bob_weight(rotor, number, found.offset_mm))
            if number == 0:
                turned = math.degrees(abs(math.atan2(found.centre_mm[1], found.centre_mm[0])))
                meaning += [f"all angles count from it, {turned:.2g}° off"] if turned > 0.01 else []
            yield _off(name, found, found.offset_mm, "across the axis", "; ".join(meaning))
        if abs(found.along_mm) > found.within_mm:
            meaning_along = _of_moved_bob_weight(rotor, number, throw.crank_radius_mm, found.along_mm)
            yield _off(name, found, abs(found.along_mm), "along the axis", meaning_along)
        yield from _other_diameter(name, found)


def _of_bob_weight(rotor: _Rotor, number: int, off_mm: float) -> str:
    if rotor.bob_weights_g is None:
        return f"{off_mm:.3g} g·mm for each gram of its bob-weight"
    return f"bob-weight × offset is {rotor.share(rotor.bob_weights_g[number] * off_mm)}"


def _of_moved_bob_weight(rotor: _Rotor, number: int, radius_mm: float, along_mm: float) -> str:
    """Return the change in a tolerance plane if a bob-weight moves along the axis, in words."""
    places = None if rotor.tolerance is None else rotor.tolerance.places_mm
    if rotor.bob_weights_g is None or rotor.tolerance is None or places is None:
        return f"a couple of {radius_mm * abs(along_mm):.3g} g·mm² for each gram of its bob-weight"
    change = rotor.bob_weights_g[number] * radius_mm * abs(along_mm / (places[1] - places[0]))
    least = min(plane.permissible_g_mm for plane in rotor.tolerance.planes)
    return f"{change:.3g} g·mm in each plane, {change / least:.2g} times the permissible {least:.4g} g·mm"


def _other_diameter(name: str, found: CylinderFound) -> Iterator[str]:
    typed = found.typed_diameter_mm
    if typed is None:
        return
    off = abs(found.diameter_mm - typed)
    if off <= SAME_DIAMETER_MM and off <= SAME_DIAMETER_SHARE * typed:
        return
    yield (
        f"{name}: ⌀{typed:.5g} mm is typed, the {_kind(found)} in the file has ⌀{found.diameter_mm:.5g} mm "
        f"at {_point(found.centre_in_file_mm)} mm: 0 g·mm, 0 % of the permissible unbalance, but webs, walls "
        f"and bearing loads follow it. Set diameter_mm = {found.diameter_mm:.5g}"
    )


def _off(name: str, found: CylinderFound, off_mm: float, where: str, meaning: str) -> str:
    x, y, z = np.round(found.centre_in_file_mm, 4) + 0.0
    return (
        f"{name}: the {_kind(found)} in the file, ⌀{found.diameter_mm:.5g} mm, is {off_mm:.3g} mm off the "
        f"typed place {where} (agreement within {found.within_mm:.2g} mm expected): {meaning}. "
        f"Set centre_mm = [{x:.6g}, {y:.6g}, {z:.6g}]"
    )


def _kind(found: CylinderFound) -> str:
    return "bore" if found.kind == "bore" else "cylinder"


def _in_file(anatomy: Anatomy, point_mm: Array) -> Array:
    back = anatomy.rotor_to_file
    there: Array = back[:3, :3] @ point_mm + back[:3, 3]
    return there


def _point(point_mm: Array) -> str:
    return f"({', '.join(f'{value:.6g}' for value in np.round(point_mm, 4) + 0.0)})"


# Whether a solid can be a crank by its density and size, and which unit would make it one.


DENSITY_KG_M3 = (500.0, 23000.0)
"""Foamed plastic to osmium: no crank is of anything lighter or heavier."""
SIZE_MM = (5.0, 5000.0)
"""Longest side of a crank: a model aircraft's to a large ship's throw."""
ODD_MM = (18.0, 3000.0)
"""Beyond these a crank is odd where another unit would make it usual: it may be drawn in that one."""
USUAL_MM = (50.0, 2000.0)
NEVER_MIXED = {MM_PER["m"], MM_PER["inch"]}


def refuse_density(crankshaft: Crankshaft) -> None:
    """Refuse a density that nothing has.

    Raises
    ------
    JobError With the unit that may be meant.
    """
    low, high = DENSITY_KG_M3
    density = crankshaft.density_g_mm3 * 1e6
    if not low <= density <= high and density > 0.0:
        meant = f"; {density * 1e3:g} if that was g/cm³" if low <= density * 1e3 <= high else ""
        raise JobError(
            f"crankshaft.density_kg_m3 is {density:g}; must be {low:g} to {high:g} kg/m³ for any metal{meant}"
        )


def refuse_size(source: Source, file: object) -> None:
    """Refuse a solid that no crank can be, by its longest side.

    Raises
    ------
    JobError With the unit that would make it one.
    """
    low, high = SIZE_MM
    longest = longest_mm(source)
    if not low <= longest <= high:
        raise JobError(
            f"{file}: the crank is {longest:.4g} mm long; expected {low:g} to {high:g} mm{_meant(source)}"
        )


def odd_size(source: Source) -> str | None:
    """Return a warning of a crank's odd size; None where it is usual, or in no unit is."""
    low, high = ODD_MM
    longest, meant = longest_mm(source), _meant(source)
    if low <= longest <= high or not meant:
        return None
    return f"the crank is {longest:.4g} mm long; odd outside {low:g} to {high:g} mm{meant}"


def longest_mm(source: Source) -> float:
    """Return the length of a solid along the file's axes, or along its own where that may count.

    Seen along the file's axes, a slanting one may look 1.7 times shorter than it is.
    """
    low, high = source.solid.bounds
    side = float((high - low).max())
    if USUAL_MM[0] <= side and math.sqrt(3.0) * side <= USUAL_MM[1]:
        return side
    away = source.solid.mesh.vertices - 0.5 * (low + high)
    _, own = np.linalg.eigh(away.T @ away)
    return max(side, float(np.ptp(away @ own, axis=0).max()))


def _meant(source: Source) -> str:
    """Ask for the units that would make a solid a crank of a usual size."""
    meant = usual_units(source)
    return f"; is its unit {' or '.join(meant)}?" if meant else ""


def usual_units(source: Source) -> dict[str, float]:
    """Return the units that would make a solid a crank of a usual size, and how much longer it would be."""
    own, longest = source.mm_per_unit, longest_mm(source)
    low, high = USUAL_MM
    if low <= longest <= high:
        return {}
    factors = {name: mm / own for name, mm in MM_PER.items() if mm != own and {mm, own} != NEVER_MIXED}
    return {name: by for name, by in factors.items() if low <= longest * by <= high}

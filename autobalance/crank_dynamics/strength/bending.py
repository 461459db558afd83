"""Bending of a crank's webs before and after its cuts, as a part of the main report."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np

from autobalance.balancing.engine_from_job import with_crankpins
from autobalance.balancing.measured import Crank
from autobalance.balancing.sections import ReportSection, State
from autobalance.crank.anatomy import Anatomy, Throw, Web
from autobalance.declare import Count, NotNegative, Ordinal
from autobalance.errors import AutobalanceError
from autobalance.finite_elements.mesher import need_libraries
from autobalance.job import Job
from autobalance.runtime import Notify, Progress, no_progress
from autobalance.solid.csg.solid import Solid
from autobalance.units import N_PER_G_MM_S2
from autobalance.value_classes import dataclass

# Bending of a crank's webs by its rods before and after its cuts: sections, and finite elements.


SECTIONS = 15
"""Sections of a web between crank axis and crankpin."""
EXAMINED_RADIUS_SHARES = (0.1, 0.9)
"""Between these shares of the crank radius, off the planes that both pins' middles lie in."""
ELEMENT_SIZE_RATIO = 3.0
"""Over the usual size of elements: to be done in seconds."""
SHARE_OF_RADIUS = 1.6
"""Size of elements on a curved surface, over its radius."""
MERGED_MM = (1e-2, 2e-2, 5e-2, 0.0)
"""Edges shorter than this are merged, tried one after the other: the mesher crashes on some, and is quick."""
LONGEST_S = 40.0
"""Processor time for the meshes [s]."""
SHARE_OF_SURFACE = 0.01
"""Share of the throw's surface, as it came, that bears more than what is taken: the largest of a coarse mesh
is at a sharp inner edge, and chance."""
TIE_TOLERANCE = 1e-6


@dataclass(frozen=True)
class WebBending:
    """Nominal stress of a web's weakest section across the throw: M c/I + Q/A, before and after [MPa]."""

    web: Ordinal
    throw: Ordinal
    before_MPa: NotNegative
    after_MPa: NotNegative


@dataclass(frozen=True)
class ThrowElements:
    """One throw by finite elements under the same load; ``failed`` is the reason if there is no result.

    ``before_MPa`` and ``after_MPa`` are what 1 % of the surface exceeds.
    """

    throw: Ordinal
    before_MPa: NotNegative | None
    after_MPa: NotNegative | None
    nodes: Count | None
    seconds: Annotated[NotNegative, "processor time"]
    failed: Annotated[str | None, "why there is none"] = None


@dataclass(frozen=True)
class Bending:
    """A force on each crankpin, across the axis, and the stress it makes in the webs."""

    force_N: Annotated[tuple[NotNegative, ...], "m r Ω² on each crankpin at service speed"]
    webs: Annotated[tuple[WebBending, ...], "webs of throws that have a separate bay"]
    elements: Annotated[ThrowElements | None, "the throw whose webs lose most"]


def inertia_forces_N(job: Job, anatomy: Anatomy) -> tuple[float, ...]:
    """Return m r Ω² of what hangs on each throw at service speed: all of its rods at top dead centre."""
    speed = job.balance.service_speed_rad_s
    forces = []
    for throw in anatomy.throws:
        parts = job.engine.of_throw(throw.number)
        weights = (*parts.weights.rotating.values(), *parts.weights.reciprocating.values())
        mass_g = parts.rods * sum(each.mass_g for each in weights)
        forces.append(mass_g * throw.crank_radius_mm * speed**2 * N_PER_G_MM_S2)
    return tuple(forces)


def bending(
    before: Crank, after: Solid | None, force_N: Sequence[float], progress: Progress = no_progress
) -> Bending:
    """Return nominal stresses of all webs next to a throw with a separate bay, and one throw by elements.

    The throw is that whose webs lose most by the cuts, the first of several. It is a beam on hinges in the
    middles of its main journals, bent by a force in the middle of its crankpin.

    Parameters
    ----------
    before : Crank
        As it came.
    after : Solid or None
        Corrected, file coordinates [mm]; None: nothing was cut.
    force_N : sequence of float
        One a throw.
    progress : callable

    Raises
    ------
    FileError
        If the extra ``fem`` is not installed.
    """
    from autobalance.crank_dynamics.torsion.throw_twist import throw_ends_mm
    from autobalance.finite_elements.mesher import need_libraries

    need_libraries()
    anatomy = before.anatomy
    was = before.source.solid.moved(anatomy.file_to_rotor)
    now = was if after is None else after.moved(anatomy.file_to_rotor)
    webs = []
    for throw, force in zip(anatomy.throws, force_N, strict=True):
        ends = throw_ends_mm(anatomy, throw)
        if isinstance(ends, str):
            continue
        for web in _webs_of(anatomy, throw):
            load = _moment_n_mm(throw, web, ends, force), force * _share(throw, web, ends)
            stress = [weakest_section_MPa(solid, throw, web, *load) for solid in (was, now)]
            webs.append(WebBending(web.number, throw.number, *stress))
    if not webs:
        return Bending(tuple(force_N), (), None)
    worst = max(
        webs,
        key=lambda each: (round(each.after_MPa / each.before_MPa / TIE_TOLERANCE) * TIE_TOLERANCE, -each.web),
    )
    throw = anatomy.throws[worst.throw - 1]
    elements = _by_elements(before, was, now, throw, force_N[worst.throw - 1], progress)
    return Bending(tuple(force_N), tuple(webs), elements)


def _webs_of(anatomy: Anatomy, throw: Throw) -> list[Web]:
    return [
        web for web in anatomy.webs if any(each.number == throw.number for each in anatomy.throws_of(web))
    ]


def _share(throw: Throw, web: Web, ends_mm: tuple[float, float]) -> float:
    """Return the share of the crankpin's force that goes through a web into its main journal."""
    z = float(throw.crankpin.centre_mm[2])
    is_above = 0.5 * (web.z_min_mm + web.z_max_mm) > z
    low, high = ends_mm
    return (z - low) / (high - low) if is_above else (high - z) / (high - low)


def _moment_n_mm(throw: Throw, web: Web, ends_mm: tuple[float, float], force_N: float) -> float:
    """Return the bending moment in the middle of a web."""
    middle = 0.5 * (web.z_min_mm + web.z_max_mm)
    return force_N * _share(throw, web, ends_mm) * min(abs(middle - end) for end in ends_mm)


def weakest_section_MPa(solid: Solid, throw: Throw, web: Web, moment_n_mm: float, force_N: float) -> float:
    """Return the stress of a web's weakest section between crank axis and crankpin."""
    x, y = throw.direction
    lay = np.eye(4)  # along the throw becomes z, along the axis x
    lay[:3, :3] = [[0.0, 0.0, 1.0], [-y, x, 0.0], [x, y, 0.0]]
    arm = solid.above(web.z_min_mm).below(web.z_max_mm).moved(lay)
    heights = throw.crank_radius_mm * np.linspace(*EXAMINED_RADIUS_SHARES, SECTIONS)
    return max(_stress_MPa(arm, float(height), moment_n_mm, force_N) for height in heights)


def _stress_MPa(arm: Solid, height_mm: float, moment_n_mm: float, force_N: float) -> float:
    section = arm.section(height_mm)
    area, first, second = section.area_moments()
    if not area > 0.0:
        return math.inf
    middle = float(first[0]) / area
    inertia = float(second[0, 0]) - area * middle**2
    low, high = section.bounds[:, 0]
    return float(moment_n_mm * max(high - middle, middle - low) / inertia + force_N / area)


def _by_elements(
    crank: Crank, was: Solid, now: Solid, throw: Throw, force_N: float, progress: Progress
) -> ThrowElements:
    """Bend a throw's metal before and after its cuts by the moment in the middles of its webs."""
    from autobalance.crank_dynamics.torsion.throw_twist import throw_ends_mm
    from autobalance.finite_elements.elasticity import STEEL
    from autobalance.finite_elements.mesher import default_size_mm
    from autobalance.finite_elements.throws import (
        Deadline,
        bodies_of_solid,
        stress_beyond_MPa,
        throw_bending_MPa,
    )

    ends = throw_ends_mm(crank.anatomy, throw)
    assert not isinstance(ends, str)
    moments = [_moment_n_mm(throw, web, ends, force_N) for web in _webs_of(crank.anatomy, throw)]
    moment_n_m = sum(moments) / len(moments) / 1e3
    begun, deadline = _spent_s(), Deadline.after(LONGEST_S)
    stress, nodes, area = [], 0, 0.0
    for number, solid in enumerate((was, now) if now is not was else (was,)):
        progress(
            f"throw {throw.number} by finite elements, {('before', 'after')[number]} its cuts", 0.5 * number
        )
        piece = with_crankpins(solid, crank).above(ends[0]).below(ends[1])
        surface = 0.5 * float(piece.mesh.doubled_areas.sum())
        area = area or SHARE_OF_SURFACE * surface
        size = ELEMENT_SIZE_RATIO * default_size_mm(piece.volume_mm3, surface)
        try:
            body = bodies_of_solid(
                piece, size, (1.0,), SHARE_OF_RADIUS, deadline, rough=True, merged_mm=MERGED_MM
            )[0]
            surface_MPa = throw_bending_MPa(body, STEEL, throw.direction)
        except AutobalanceError as error:  # the sections hold all the same
            return ThrowElements(throw.number, None, None, None, _spent_s() - begun, str(error))
        stress.append(moment_n_m * stress_beyond_MPa(body, surface_MPa, area))
        nodes = body.nodes
    return ThrowElements(throw.number, stress[0], stress[-1], nodes, _spent_s() - begun)


def _spent_s() -> float:
    """Return the processor time of this process and of its children that have ended [s]."""
    return sum(os.times()[:4])


# Stress of the webs, before and after, as lines and as rows of the page.


def bending_text(bending: Bending) -> str:
    """Return stresses of the webs side by side, as lines."""
    rows = [("Bending of the webs", "before", "after"), *bending_rows(bending)]
    wide = [max(len(row[k]) for row in rows) for k in range(3)]
    lines = [
        f"{'' if number == 0 else '  '}{row[0]:<{wide[0] + (2 if number == 0 else 0)}}"
        f"  {row[1]:>{wide[1]}}  {row[2]:>{wide[2]}}"
        for number, row in enumerate(rows)
    ]
    return "\n".join([*lines, *(f"  {line}" for line in bending_words(bending))])


def bending_rows(bending: Bending) -> list[tuple[str, str, str]]:
    """Return (name, stress before, stress after) of each web, and of the throw that was meshed."""
    rows = [
        (f"web {each.web}, weakest section", _mpa(each.before_MPa), _mpa(each.after_MPa))
        for each in bending.webs
    ]
    elements = bending.elements
    if elements is not None and elements.before_MPa is not None and elements.after_MPa is not None:
        stress = _mpa(elements.before_MPa), _mpa(elements.after_MPa)
        rows.append((f"throw {elements.throw}, finite elements", *stress))
    return rows


def bending_words(bending: Bending) -> list[str]:
    """Return the load behind the stresses, and mesh and time of the finite-element analysis."""
    forces = [each for each in bending.force_N if each > 0.0]
    if not bending.webs:
        return ["no throw is alone between two main journals; nothing is computed"]
    load = f"{min(forces, default=0.0) / 1e3:.1f}"
    if forces and max(forces) > 1.001 * min(forces):
        load += f" to {max(forces) / 1e3:.1f}"
    words = [f"nominal, under the inertia of the rods at top dead centre: {load} kN on each crankpin"]
    elements = bending.elements
    if elements is None:
        return words
    if elements.failed is not None:
        words.append(f"no finite elements of throw {elements.throw}: {elements.failed}")
    else:
        words.append(
            "finite elements: stress that 1 % of the throw's surface exceeds; a coarse mesh of "
            f"{elements.nodes} nodes, {elements.seconds:.0f} s; "
            "before and after may differ by 10 % from their meshes alone"
        )
    return words


def _mpa(stress: float) -> str:
    return f"{stress:.2f} MPa"


# Bending of the webs as a part of the main report, which ``--fem`` asks for.


def _ended(before: State, after: State, notify: Notify) -> Bending:
    forces = inertia_forces_N(after.job, after.crank.anatomy)
    cut = None if after.solid is before.solid else after.solid
    return bending(after.crank, cut, forces, lambda text, _: notify(text))


def _page(found: Bending) -> tuple[str, dict[str, Any]]:
    return "bending.html", {"rows": bending_rows(found), "words": bending_words(found)}


SECTION = ReportSection(
    Bending,
    "with --fem: stress of the webs, before and after",
    begun=lambda before: before,
    ended=_ended,
    text=bending_text,
    page=_page,
    unchecked=lambda _: "finite elements on meshes that are not kept; `balance --fem` computes them again",
    require=need_libraries,
)

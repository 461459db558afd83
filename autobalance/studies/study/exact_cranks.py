"""Cranks made to a plan, each cut and measured: what the linear model is checked against."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from autobalance.balancing import rotor_from_job
from autobalance.correction import KINDS
from autobalance.correction.contract import Cut
from autobalance.job import EngineParts, PartWeights
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.running_gear.parts import bob_weight_moments
from autobalance.solid.csg.solid import Solid, union
from autobalance.studies.study import causes
from autobalance.studies.study.causes import TABLES, heavier, square_to
from autobalance.studies.study.plan import StudyPlan
from autobalance.studies.study.statistics import effect_of, state_of
from autobalance.types import Array
from autobalance.units import G_PER_MM3_PER_KG_M3

Deviations = Mapping[str, Array]
"""Values of one crank: by label, (1,) or (2,)."""


def exact_state(plan: StudyPlan, deviations: Deviations) -> Array:
    """Return the state (4,) of one crank with these deviations, its metal cut and measured again."""
    change = _cut(plan, deviations) - _cut(plan, {})
    density = plan.job.crankshaft.density_g_mm3
    heavier_by = 0.0
    if causes.DENSITY in deviations:
        nominal = plan.job.crankshaft.density_g_mm3 / G_PER_MM3_PER_KG_M3
        heavier_by = float(deviations[causes.DENSITY][0]) / nominal
    pressed_in = plan.crank_and_slugs - plan.metal
    metal = (plan.metal + change.scaled(density)).scaled(1.0 + heavier_by)
    slugs = pressed_in + _pressed_in(plan, deviations) - _pressed_in(plan, {})
    engine = drawn_engine(plan, deviations)
    loads = rotor_from_job.throw_loads(plan.crank.anatomy, engine)
    bobs = bob_weight_moments(loads, _drawn_factor(plan, deviations, heavier_by))
    others = rotor_from_job.beside_throws(engine) - rotor_from_job.overbalance_moments(
        plan.job, plan.tolerance
    )
    turning = (metal + slugs + bobs).moved(_onto_true_axis(plan, deviations))
    state = effect_of(turning + others) + state_of(plan.beside)
    for part in plan.job.engine.attached:
        drawn = deviations.get(f"engine.attached.{part.name}")
        if drawn is not None:
            state = state + effect_of(
                rotor_from_job.unbalance_at((float(drawn[0]), float(drawn[1])), part.z_mm)
            )
    z = float(plan.crank.moments.centre_mm[2])
    for name in ("facets", "rounding", "axis"):
        drawn = deviations.get(f"study.{name}")
        if drawn is not None:
            state = state + effect_of(rotor_from_job.unbalance_at((float(drawn[0]), float(drawn[1])), z))
    return state


def _cut(plan: StudyPlan, deviations: Deviations) -> Moments:
    """Return the volume moments (density 1, rotor frame) of the crank with its cuts as they came out."""
    frame = plan.crank.anatomy.file_to_rotor
    solid = plan.rotor.solid
    for adds in (True, False):
        tools = [tool for tool, added in _tools(plan, deviations) if added == adds and not tool.is_empty]
        if tools:
            tool = union(tools).moved(plan.crank.anatomy.rotor_to_file)
            solid = solid + tool if adds else solid - tool
    return solid.moments(1.0, frame)


def _tools(plan: StudyPlan, deviations: Deviations) -> list[tuple[Solid, bool]]:
    return [
        (cut.tool(_depth(number, depth, deviations)).moved(motion), cut.adds_metal)
        for number, (cut, depth), motion in _cuts_with_motion(plan, deviations)
    ]


def _pressed_in(plan: StudyPlan, deviations: Deviations) -> Moments:
    total = Moments.zero()
    for number, (cut, depth), motion in _cuts_with_motion(plan, deviations):
        total = total + cut.pressed_in(_depth(number, depth, deviations)).moved(motion)
    return total


def _cuts_with_motion(
    plan: StudyPlan, deviations: Deviations
) -> Iterator[tuple[int, tuple[Cut, float], Array]]:
    """Yield each cut's number, itself with its depth, and how it lies beside its place."""
    result = plan.result
    holes = [number for number, cut in enumerate(result.corrections, 1) if KINDS[cut.kind].has_axis]
    for number, cuts in enumerate(result.made, 1):
        motion = np.eye(4)
        if number in holes:
            where = "" if len(holes) == 1 else f"[hole {holes.index(number) + 1}]"
            done = result.corrections[number - 1]
            axes = square_to(np.asarray(done.details["inward"]))
            shift = deviations.get(f"{causes.POSITION}{where}", np.zeros(2)) @ axes
            turn = np.radians(deviations.get(f"{causes.WANDER}{where}", np.zeros(2))) @ axes
            motion = _moved_about(done.position_mm, turn, shift)
        yield number, cuts, motion


def _depth(number: int, depth_mm: float, deviations: Deviations) -> float:
    for label in (causes.DEPTH, f"{causes.DEPTH}[cut {number}]"):
        if label in deviations:
            return max(depth_mm + float(deviations[label][0]), 0.0)
    return depth_mm


def _moved_about(point_mm: Array, turn_rad: Array, shift_mm: Array) -> Array:
    """Return the motion (4, 4) that turns about a point by a rotation vector and then shifts."""
    motion = np.eye(4)
    rotation = Rotation.from_rotvec(turn_rad).as_matrix()
    motion[:3, :3] = rotation
    motion[:3, 3] = point_mm - rotation @ point_mm + shift_mm
    return motion


def drawn_engine(plan: StudyPlan, deviations: Deviations) -> EngineParts:
    """Return the engine with its parts as heavy as they came out."""
    engine = plan.job.engine
    by_throw = {}
    for throw in plan.crank.anatomy.throws:
        parts = engine.of_throw(throw.number)
        weights = parts.weights
        for table in TABLES:
            for name in getattr(parts.weights, table):
                cause = f"engine.{table}_g.{name}"
                for label in (cause, f"{cause}[throw {throw.number}]"):
                    if label in deviations:
                        weights = heavier(weights, table, name, float(deviations[label][0]))
        by_throw[throw.number] = replace(parts, weights=weights)
    return replace(engine, by_throw=by_throw)


def _drawn_factor(plan: StudyPlan, deviations: Deviations, heavier_by: float) -> float:
    """Return the target factor, found again where it is that of the original parts."""
    original = plan.job.original
    if plan.job.balance.factor is not None or original is None:
        return plan.rotor.factor
    weights: PartWeights = original
    for table in TABLES:
        for name in getattr(original, table):
            drawn = deviations.get(f"original.{table}_g.{name}")
            if drawn is not None:
                weights = heavier(weights, table, name, float(drawn[0]))
    loads = rotor_from_job.throw_loads(plan.crank.anatomy, plan.job.engine, weights)
    attached = rotor_from_job.beside_throws(plan.job.engine)
    factor = rotor_from_job.crank_factor(plan.crank.moments.scaled(1.0 + heavier_by), loads, attached)
    return plan.rotor.factor if factor is None else factor


def _onto_true_axis(plan: StudyPlan, deviations: Deviations) -> Array:
    """Return the motion (4, 4) that puts the line through the drawn journals onto z."""
    journals = plan.crank.anatomy.main_journals
    ends = []
    for journal in journals[:1] + journals[-1:]:
        drawn = deviations.get(f"{causes.JOURNAL}[journal {journal.number}]")
        if drawn is None:
            return np.eye(4)
        ends.append(np.array([drawn[0], drawn[1], journal.centre_mm[2]]))
    low, high = ends
    direction = (high - low) / np.linalg.norm(high - low)
    turn = np.cross(direction, [0.0, 0.0, 1.0])
    sine = float(np.linalg.norm(turn))
    rotation_vector = turn * (math.asin(sine) / sine) if sine > 0.0 else turn
    return _moved_about(low, rotation_vector, np.array([-low[0], -low[1], 0.0]))

"""Runs: bare cylinders along the crank, where sections stay one and the same circle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.crank.anatomy import Array
from autobalance.crank.circles import fit_circle
from autobalance.crank.stations import Lengthwise

SAME_CENTRE = 0.03
"""Circles of two sections belong to one axis when their centres are closer than this share of the radius."""
SAME_RADIUS = 0.01
"""... and to one cylinder when their radii differ by less than this share."""
ON_CYLINDER = 1e-5
"""A vertex lies on a cylinder when it is off by less than this share of the radius (and rounding)."""
ROUNDING = 3e-7
"""Rounding of a file's coordinates (float32), as a share of the greatest coordinate, with some room."""
LEAST_WIDTH = 0.05
"""Bare cylinders shorter than this share of their radius are chamfers and steps."""


@dataclass(frozen=True, eq=False)
class Run:
    """A bare cylinder: ``centre`` (2,) and ``radius`` in the turned axes, z range of its metal [mm]."""

    centre: Array
    radius: float
    z_low: float
    z_high: float

    @property
    def width(self) -> float:
        """Length of the bare cylinder [mm]."""
        return self.z_high - self.z_low

    @property
    def z_mid(self) -> float:
        """Middle [mm]."""
        return 0.5 * (self.z_low + self.z_high)


def find_runs(long: Lengthwise, rounding_mm: float) -> list[Run]:
    """Return the bare cylinders whose whole section piece is their circle, by increasing z."""
    chains: list[list[tuple[int, Array, float]]] = []
    open_chains: list[list[tuple[int, Array, float]]] = []
    for place, section in enumerate(long.sections):
        still: list[list[tuple[int, Array, float]]] = []
        for piece in section.pieces:
            circle = piece.circle
            if circle is None:
                continue
            here = (place, circle.centre, circle.radius)
            for chain in open_chains:
                if _continues(chain[0], here) and chain[-1][0] == place - 1:
                    chain.append(here)
                    still.append(chain)
                    break
            else:
                chains.append([here])
                still.append(chains[-1])
        open_chains = still
    runs = [_run(long, chain, rounding_mm) for chain in chains]
    return sorted((run for run in runs if run is not None), key=lambda run: run.z_mid)


def _continues(first: tuple[int, Array, float], here: tuple[int, Array, float]) -> bool:
    (_, centre, radius), (_, other, size) = first, here
    return (
        abs(size - radius) < SAME_RADIUS * radius
        and float(np.linalg.norm(other - centre)) < SAME_CENTRE * radius
    )


def _run(long: Lengthwise, chain: Sequence[tuple[int, Array, float]], rounding_mm: float) -> Run | None:
    """Return the cylinder that a chain of circles shows, its ends where its last vertices stand."""
    centre = np.median([c for _, c, _ in chain], axis=0)
    radius = float(np.median([r for *_, r in chain]))
    before, after = chain[0][0] - 1, chain[-1][0] + 1
    z_from = long.sections[before].z_mm if before >= 0 else -np.inf
    z_to = long.sections[after].z_mm if after < len(long.sections) else np.inf
    return bare_cylinder(long.vertices, centre, radius, (z_from, z_to), rounding_mm)


def bare_cylinder(
    vertices: Array, centre: Array, radius: float, z_range: tuple[float, float], rounding_mm: float
) -> Run | None:
    """Fit the cylinder along z that vertices in a range of z lie on; None if they show none.

    A cylinder's vertices lie on it at (at least) two heights, however coarse its facets; those of fillets,
    tapers and chamfers do not.
    """
    z = vertices[:, 2]
    near = vertices[(z >= z_range[0]) & (z <= z_range[1])]
    away = np.linalg.norm(near[:, :2] - centre, axis=1)
    near = near[np.abs(away - radius) < 0.04 * radius]
    for share in (3e-3, 1e-3, 2e-4):
        if len(near) < 8:
            return None
        away = np.linalg.norm(near[:, :2] - centre, axis=1)
        radius = _densest(away, share * radius)
        near = near[np.abs(away - radius) <= share * radius + rounding_mm]
        if len(near) < 8:
            return None
        centre, radius = fit_circle(near[:, :2])
    off = np.abs(np.linalg.norm(near[:, :2] - centre, axis=1) - radius)
    slack = max(ON_CYLINDER * radius + rounding_mm, 2.0 * float(np.median(off)))
    on = near[off <= slack]
    low, high = float(on[:, 2].min()), float(on[:, 2].max())
    if len(on) < 8 or high - low < LEAST_WIDTH * radius:
        return None
    return Run(centre, radius, low, high)


def _densest(values: Array, width: float) -> float:
    """Return the middle of the window of ``width`` that holds most values; the largest of equals."""
    ranked = np.sort(values)
    held = np.searchsorted(ranked, ranked + width, side="right") - np.arange(len(ranked))
    best = len(held) - 1 - int(np.argmax(held[::-1]))
    return float(np.median(ranked[best : best + held[best]]))


def common_axis(vertices: Array, runs: Sequence[Run], rounding_mm: float) -> tuple[Array, Array]:
    """Return the line that is the common axis of cylinders nearly along z: point (3,), unit direction (3,).

    Least squares over the vertices on the cylinders, linear in the line's position and slope and in each
    radius; the vertices lie on the true surface however coarse the facets are.
    """
    where, arms, who = [], [], []
    for number, run in enumerate(runs):
        z = vertices[:, 2]
        near = vertices[(z >= run.z_low) & (z <= run.z_high)]
        arm = near[:, :2] - run.centre
        away = np.linalg.norm(arm, axis=1)
        on = np.abs(away - run.radius) <= 2e-4 * run.radius + rounding_mm
        where.append(near[on])
        arms.append(arm[on] / away[on, None])
        who.append(np.full(int(on.sum()), number))
    points, unit, owner = np.concatenate(where), np.concatenate(arms), np.concatenate(who)
    middle, scale = float(points[:, 2].mean()), max(float(np.ptp(points[:, 2])), 1e-12)
    lever = (points[:, 2] - middle) / scale
    start = runs[0].centre
    rows = np.column_stack([unit, unit * lever[:, None], owner[:, None] == np.arange(len(runs))])
    target = ((points[:, :2] - start) * unit).sum(axis=1)
    keep = np.ones(len(rows), dtype=bool)
    for _ in range(3):
        kept = rows[keep]
        solution = np.linalg.lstsq(kept.T @ kept, kept.T @ target[keep], rcond=None)[0]
        off = np.abs(rows @ solution - target)
        keep = off <= max(4.0 * float(np.median(off)), 1e-3 * rounding_mm)
    slope = np.array([solution[2] / scale, solution[3] / scale, 1.0])
    point = np.array([start[0] + solution[0], start[1] + solution[1], middle])
    return point, slope / np.linalg.norm(slope)

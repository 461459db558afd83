"""The stiffness of each throw of a crank's own metal, cut out between its journals and twisted."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import astuple
from functools import partial
from itertools import groupby

import numpy as np

from autobalance.balancing.engine_from_job import with_crankpins
from autobalance.balancing.measured import Crank
from autobalance.crank.anatomy import Anatomy, Throw
from autobalance.crank_dynamics.torsion.chain import ThrowShape
from autobalance.crank_dynamics.torsion.from_job import throw_shapes
from autobalance.errors import SolidError
from autobalance.finite_elements.analysis import COARSENING
from autobalance.finite_elements.elasticity import ElasticMaterial
from autobalance.finite_elements.mesher import default_size_mm, need_libraries
from autobalance.finite_elements.throws import Deadline, TwistStiffness, bodies_of_solid, twist_stiffness
from autobalance.runtime import Progress, no_progress
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.value_classes import dataclass

ELEMENT_SIZE_RATIO = 3.0
"""Over the usual size of elements: formulas beside are worth 10 to 20 %, this some 1 %."""
SHARES_OF_RADIUS = (0.8, 0.6)
"""Size of elements on a curved surface, over its radius, the second where the mesher fails at the first."""
LONGEST_S = 45.0
"""Time for the meshes of all throws [s]: on some solids the mesher never ends."""
EQUAL_SIZES_SHARE = 1e-3
EQUAL_VOLUME_SHARE = 1e-2
EQUAL_MOMENTS_SHARE = 3e-3
"""Bays whose sizes, volumes, and first and second moments agree to these shares count as equal. Drillings on
another side change the stiffness by 0.1 %, and the meshes leave 0.7 %. The difference of volumes, or of the
twist of longer journals, counts as error too."""


@dataclass(frozen=True)
class ThrowTwist:
    """A throw's stiffness, or the reason for its absence."""

    stiffness: TwistStiffness | None
    reason: str | None = None


@dataclass(frozen=True, eq=False)
class _BayKey:
    """Values that bays of one kind share: sizes and angles; volume, reach to the first crankpin, inertia.

    ``softer_per_mm``: share of the twist of a bay that a millimetre of its journals takes.
    """

    sizes_mm: Array
    moments: Array
    length_mm: float
    softer_per_mm: float

    @classmethod
    def of(cls, piece: Solid, throws: Sequence[Throw], shapes: Sequence[ThrowShape]) -> _BayKey:
        moments, throw = piece.moments(1.0), throws[0]
        second = moments.second_g_mm2[:2, :2]
        angles = [math.remainder(each.angle_rad - throw.angle_rad, math.tau) for each in throws[1:]]
        towards = float(moments.first_g_mm[:2] @ throw.direction)
        along = float(throw.direction @ second @ throw.direction)
        return cls(
            np.array([*(size for shape in shapes for size in astuple(shape)), *angles]),
            np.array([moments.mass_g, towards, along, float(np.trace(second))]),
            float(np.diff(piece.bounds[:, 2])[0]),
            1.0
            / (shapes[0].journal_mm ** 4 - shapes[0].journal_bore_mm ** 4)
            / sum(shape.ker_wilson_per_mm3() for shape in shapes),
        )

    def lost(self, other: _BayKey) -> float:
        """Return the possible difference of stiffness from another bay's, a share.

        As much as the volumes, or as longer journals twist more.
        """
        longer_mm = abs(self.length_mm - other.length_mm)
        return max(abs(float(self.moments[0] / other.moments[0]) - 1.0), longer_mm * self.softer_per_mm)

    def is_like(self, other: _BayKey) -> bool:
        return (
            len(self.sizes_mm) == len(other.sizes_mm)
            and np.allclose(self.sizes_mm, other.sizes_mm, rtol=EQUAL_SIZES_SHARE)
            and np.allclose(self.moments[0], other.moments[0], rtol=EQUAL_VOLUME_SHARE)
            and np.allclose(self.moments[1:], other.moments[1:], rtol=EQUAL_MOMENTS_SHARE)
        )


def twisted(
    piece: Solid,
    material: ElasticMaterial,
    size_mm: float | None,
    deadline: Deadline,
    error_share: float | None,
) -> TwistStiffness:
    """Return the stiffness of a bay by finite elements; with the share of another's error, on one mesh.

    Raises
    ------
    SolidError
        If it cannot be meshed, or not in time.
    """
    if size_mm is None:
        mesh = piece.mesh
        area = 0.5 * float(mesh.doubled_areas.sum())
        size_mm = ELEMENT_SIZE_RATIO * default_size_mm(piece.volume_mm3, area)
    for share in SHARES_OF_RADIUS:
        try:
            bodies = (
                bodies_of_solid(piece, factor * size_mm, (1.0,), factor * share, deadline, rough=True)[0]
                for factor in (COARSENING if error_share is None else COARSENING[-1:])
            )
            return twist_stiffness(bodies, piece.volume_mm3, material, error_share)
        except SolidError:
            if share == SHARES_OF_RADIUS[-1]:
                raise
    raise AssertionError  # the last share has returned or raised


def throw_twists(
    crank: Crank,
    youngs_mpa: float,
    shear_mpa: float,
    size_mm: float | None,
    progress: Progress = no_progress,
    stiffness_of_bay: Callable[..., TwistStiffness] = twisted,
) -> list[ThrowTwist]:
    """Return the torsional stiffness of every throw by quadratic tetrahedra on three meshes.

    A throw reaches from the middle of the main journal before it to the middle of the one after it. Throws
    between the same two mains are twisted together, and share the twist as their formulas (Ker Wilson) give
    it. Equal throws are solved once; a different one is solved on the finest mesh alone, with the error of
    the first. A crankpin that is not in the file is added, of the bore's diameter, as one piece with the
    webs.

    Raises
    ------
    FileError
        If the extra is not installed.

    Notes
    -----
    A throw that cannot be meshed in time has no stiffness but the reason.
    """
    need_libraries()
    material = ElasticMaterial(youngs_mpa, youngs_mpa / (2.0 * shear_mpa) - 1.0, 7.85e-9)
    solid = with_crankpins(crank.source.solid.moved(crank.anatomy.file_to_rotor), crank)
    twists: list[ThrowTwist] = []
    known: list[tuple[_BayKey, TwistStiffness]] = []
    shapes = throw_shapes(crank)
    deadline = Deadline.after(LONGEST_S)
    for ends, group in groupby(crank.anatomy.throws, partial(bay_ends_mm, crank.anatomy)):
        throws = list(group)
        names = ", ".join(str(throw.number) for throw in throws)
        progress(f"twisting throw {names}", len(twists) / len(crank.anatomy.throws))
        if isinstance(ends, str):
            twists += [ThrowTwist(None, ends)] * len(throws)
            continue
        piece, sizes = solid.above(ends[0]).below(ends[1]), [shapes[throw.number - 1] for throw in throws]
        looks = _BayKey.of(piece, throws, sizes)
        alike = [each.with_error(looks.lost(other)) for other, each in known if looks.is_like(other)]
        try:
            error = known[0][1].error_share if known else None
            stiffness = alike[0] if alike else stiffness_of_bay(piece, material, size_mm, deadline, error)
        except SolidError as error:  # the formulas still hold: the rest of the report is worth having
            twists += [ThrowTwist(None, str(error))] * len(throws)
            continue
        known.append((looks, stiffness))
        twists += [ThrowTwist(each) for each in _shared(stiffness, sizes)]
    return twists


def _shared(whole: TwistStiffness, shapes: Sequence[ThrowShape]) -> list[TwistStiffness]:
    """Return the stiffness of each throw of a bay: in series they are as stiff as all of it."""
    flexibilities = [shape.ker_wilson_per_mm3() for shape in shapes]
    return [whole.scaled(sum(flexibilities) / each) for each in flexibilities]


def bay_ends_mm(anatomy: Anatomy, throw: Throw) -> tuple[float, float] | str:
    """Return the middles of the journals beside a throw and those that it shares them with, or why not."""
    z = float(throw.crankpin.centre_mm[2])
    middles = [float(main.centre_mm[2]) for main in anatomy.main_journals]
    below, above = [m for m in middles if m < z], [m for m in middles if m > z]
    if not (below and above):
        return "it has no main journal on one side"
    return max(below), min(above)


def throw_ends_mm(anatomy: Anatomy, throw: Throw) -> tuple[float, float] | str:
    """Return the middles of the journals next to a throw, or the reason for their absence."""
    ends = bay_ends_mm(anatomy, throw)
    if isinstance(ends, str):
        return ends
    low, high = ends
    if sum(low < float(each.crankpin.centre_mm[2]) < high for each in anatomy.throws) > 1:
        return "it shares its bay with another throw"
    return low, high

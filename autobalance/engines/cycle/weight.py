"""Weight of crank, rods and pistons in the loads of a cycle: the first of the loads on the main bearings.

A mass m has the load −m (a − g) on what carries it: its weight is a part of every load that does not grow
with the speed. The wall carries a piston's weight across the cylinder, the rod its weight along it, the
crankpin the rod's share, and the mains the crank's metal by levers. The torque of weights has no mean: its
work is the change of their potential energy.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence

import numpy as np

from autobalance.declare import ANY, NOT_NEGATIVE, POSITIVE, Key, Range, Values
from autobalance.running_gear.loads import Loads, lever_shares, loads
from autobalance.running_gear.whole_engine import Engine
from autobalance.types import Array, Complex
from autobalance.units import G_PER_KG, N_M_PER_G_MM2_S2, N_PER_G_MM_S2
from autobalance.value_classes import dataclass

FREE_FALL_M_S2 = 9.80665
MM_PER_M = 1e3
TILT = Range("must be −90 to 90", least=-90.0, most=90.0)

PART = (
    Key("name", str, "description: flywheel, clutch, sprocket", default=""),
    Key("mass_kg", float, "mass", NOT_NEGATIVE),
    Key("z_mm", float, "place along the crank axis", ANY),
)
GRAVITY = (
    Key(
        "direction_deg",
        float,
        "direction of the weight in the engine's frame, counter-clockwise from x seen from +z: 180 for a "
        "cylinder that is upright along x",
        ANY,
    ),
    Key("m_s2", float, "acceleration of free fall", POSITIVE, FREE_FALL_M_S2),
    Key("tilt_deg", float, "angle of the crank axis to the horizontal; its thrust is left out", TILT, 0.0),
    Key("part", says="parts on the crank besides its file and `[[engine.attached]]`", keys=PART,
        many=True, default=()),
)  # fmt: skip
"""Keys of ``[cycle.gravity]``."""


@dataclass(frozen=True)
class Gravity:
    """Free fall across the crank axis, x + iy in the engine's frame [mm/s²], and masses on the crank.

    ``parts`` are masses [g] and their places along the axis [mm].
    """

    fall_mm_s2: complex
    parts: tuple[tuple[float, float], ...] = ()


def gravity_of(values: Values | None) -> Gravity | None:
    """Return the gravity of ``[cycle.gravity]``; None without one."""
    if values is None:
        return None
    size = values["m_s2"] * MM_PER_M * math.cos(math.radians(values["tilt_deg"]))
    parts = tuple((each["mass_kg"] * G_PER_KG, each["z_mm"]) for each in values["part"])
    return Gravity(cmath.rect(size, math.radians(values["direction_deg"])), parts)


@dataclass(frozen=True, eq=False)
class WeightLoads:
    """Loads of weights over the crank angle.

    Attributes
    ----------
    rods : Loads
        Of rods and pistons.
    crank_mains_n : (m,) complex
        Of the crank's metal and its parts on each main, x + iy in the engine's frame [N].
    torque_n_m : (n,) float
        Of all weights on the crank, positive in its direction of rotation [N·m].
    crank_n : complex
        Weight of the crank and its parts [N].
    """

    rods: Loads
    crank_mains_n: Complex
    torque_n_m: Array
    crank_n: complex

    @property
    def mains_n(self) -> Complex:
        """Load (m, n) of all weights on each main, x + iy [N]."""
        of_rods: Complex = self.rods.main_n[..., 0] + 1j * self.rods.main_n[..., 1]
        return of_rods + self.crank_mains_n[:, None]


def weight_loads(
    engine: Engine, gravity: Gravity, mains_z_mm: Sequence[float], angle_rad: Array
) -> WeightLoads:
    """Return the loads of weights at crank angles.

    Parameters
    ----------
    engine : Engine
        With the masses of its crank's pieces; mirrored if it turns clockwise.
    gravity : Gravity
        In the engine's own frame.
    mains_z_mm : sequence of float
        Increasing, at least two [mm].
    angle_rad : (n,) float
        Crank angles [rad].

    References
    ----------
    Hoem & Røsholm 2016, Sec. 4.2.1: the weight of the crankshaft is the first of three loads that a friction
    model of its bearings needs.
    """
    fall = gravity.fall_mm_s2.conjugate() if engine.clockwise else gravity.fall_mm_s2
    rods = loads(Engine(engine.cylinders), mains_z_mm, 0.0, angle_rad, gravity_mm_s2=fall)
    pieces = [(piece.mass_g, piece.z_mm) for piece in engine.crank] + list(gravity.parts)
    shares = sum(
        (mass * lever_shares(z, mains_z_mm) for mass, z in pieces),
        np.zeros(len(mains_z_mm), dtype=np.float64),
    )
    unbalance = sum((complex(*piece.unbalance_g_mm) for piece in engine.crank), 0j)
    of_crank = (np.exp(-1j * angle_rad) * unbalance.conjugate() * fall).imag * N_M_PER_G_MM2_S2
    return WeightLoads(
        rods,
        np.asarray(shares * fall * N_PER_G_MM_S2),
        np.asarray(of_crank - rods.torque_n_m),
        sum(mass for mass, _ in pieces) * fall * N_PER_G_MM_S2,
    )

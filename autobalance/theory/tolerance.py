"""Balance tolerances, planes, and units of unbalance."""

from __future__ import annotations

import numpy as np

from autobalance.rigid_rotor import tolerance as exact
from autobalance.rigid_rotor.tolerance import listed_grade, specific_unbalance_mm
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.units import G_MM_PER, RAD_S_PER_RPM
from autobalance.value_classes import dataclass


@dataclass(frozen=True)
class Permissible:
    """Permissible residual unbalance of a rotor at a grade."""

    permissible_g_mm: float
    specific_unbalance_um: float


@dataclass(frozen=True)
class Shares:
    """Permissible residual unbalance in two tolerance planes."""

    a_g_mm: float
    b_g_mm: float


@dataclass(frozen=True)
class Achieved:
    """The grade that a residual achieves, and the finest listed one that it meets."""

    grade_mm_s: float
    listed_mm_s: float | None


@dataclass(frozen=True)
class InPlanes:
    """Dynamic unbalance: equivalent vectors in two planes."""

    a_g_mm: tuple[float, float]
    b_g_mm: tuple[float, float]


def permissible_unbalance(rotor_mass_g: float, grade_mm_s: float, speed_rpm: float) -> Permissible:
    """Return the permissible residual unbalance U_per = m G/Ω.

    Parameters
    ----------
    rotor_mass_g, grade_mm_s, speed_rpm : float
        [g, mm/s, 1/min]

    References
    ----------
    ISO 21940-11:2016, 6.2; Hoem & Røsholm 2016, Eq. 4.15 (2.7 g printed for 2.7 kg).

    Examples
    --------
    >>> round(permissible_unbalance(2700.0, 6.3, 15200.0).permissible_g_mm, 2)
    10.69
    """
    speed = speed_rpm * RAD_S_PER_RPM
    permissible = exact.permissible_unbalance_g_mm(rotor_mass_g, grade_mm_s, speed)
    return Permissible(permissible, 1e3 * specific_unbalance_mm(grade_mm_s, speed))


def achieved_grade(residual_g_mm: float, rotor_mass_g: float, speed_rpm: float) -> Achieved:
    """Return the grade that a residual achieves, G = U Ω/m.

    Parameters
    ----------
    residual_g_mm, rotor_mass_g, speed_rpm : float
        [g·mm, g, 1/min]

    References
    ----------
    ISO 21940-11:2016, 6.2.

    Examples
    --------
    >>> round(achieved_grade(7.39, 2700.0, 15200.0).grade_mm_s, 3)
    4.357
    """
    grade = exact.achieved_grade_mm_s(residual_g_mm, rotor_mass_g, speed_rpm * RAD_S_PER_RPM)
    listed = listed_grade(grade)
    return Achieved(grade, None if listed is None else listed.grade_mm_s)


def plane_shares(permissible_g_mm: float, z_centre_mm: float, z_a_mm: float, z_b_mm: float) -> Shares:
    """Return the permissible unbalance's shares in two planes, by levers within the standard's bounds.

    Parameters
    ----------
    permissible_g_mm : float
        Of the rotor [g·mm].
    z_centre_mm, z_a_mm, z_b_mm : float
        Centre of mass and planes along the axis [mm].

    References
    ----------
    ISO 21940-11:2016, 7.2: 0.3 to 0.7 with the centre between the planes, else 0.3 and 1.3.

    Examples
    --------
    >>> plane_shares(10.0, 0.0, -40.0, 40.0)
    Shares(a_g_mm=5.0, b_g_mm=5.0)
    """
    a, b = exact.share_between_planes(permissible_g_mm, z_centre_mm, z_a_mm, z_b_mm)
    return Shares(float(a), float(b))


def unbalance_in_planes(
    x_g_mm: float,
    y_g_mm: float,
    moment_x_g_mm2: float,
    moment_y_g_mm2: float,
    z_a_mm: float,
    z_b_mm: float,
) -> InPlanes:
    """Return the vectors in two planes that stand for a resultant and its moment about z = 0.

    U_A = (z_B U − P)/(z_B − z_A), U_B = (P − z_A U)/(z_B − z_A).

    Parameters
    ----------
    x_g_mm, y_g_mm : float
        Resultant U [g·mm].
    moment_x_g_mm2, moment_y_g_mm2 : float
        P = ∫ z (x, y) dm [g·mm²].
    z_a_mm, z_b_mm : float
        Planes [mm].

    References
    ----------
    ISO 21940-11:2016, 4.5; Hoem & Røsholm 2016, Sec. 2.1 (equal shares only for a symmetric crank).

    Examples
    --------
    >>> unbalance_in_planes(10.0, 20.0, 0.0, 0.0, -30.0, 10.0)
    InPlanes(a_g_mm=(2.5, 5.0), b_g_mm=(7.5, 15.0))
    """
    unbalance = Unbalance(np.array([x_g_mm, y_g_mm]), np.array([moment_x_g_mm2, moment_y_g_mm2]))
    a, b = unbalance.in_planes(z_a_mm, z_b_mm).tolist()
    return InPlanes((a[0], a[1]), (b[0], b[1]))


def convert_unbalance(value: float, unit: str, to: str = "g·mm") -> float:
    """Return an unbalance in another unit.

    Parameters
    ----------
    value : float
    unit, to : str
        g·mm, kg·mm, g·cm, g·in or oz·in, however spelt: oz-in, gmm.

    Raises
    ------
    ValueError
        If a unit is not known.

    References
    ----------
    1 oz·in = 720.078 g·mm; Ruckle 2014 prints 1439, 359 and 143 g·mm for 2, 0.5 and 0.2 oz·in.

    Examples
    --------
    >>> round(convert_unbalance(0.5, "oz-in"), 3)
    360.039
    """
    return value * _g_mm_per(unit) / _g_mm_per(to)


def _g_mm_per(typed: str) -> float:
    bare = _bare(typed)
    for name, size in G_MM_PER.items():
        if _bare(name) == bare:
            return size
    raise ValueError(f"the unit {typed!r} is not known; must be one of {', '.join(G_MM_PER)}")


def _bare(unit: str) -> str:
    return "".join(letter for letter in unit.lower() if letter.isalpha())

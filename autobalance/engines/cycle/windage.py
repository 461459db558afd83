"""Windage: the torque that discs and webs take to turn in air, or in air with oil: an order of size.

Each figure has two ends. The low one is a smooth disc in the laminar state, or in a close case whose air
turns with it. The high one is a free disc in the turbulent state, whose edges push still air. SI units.
"""

from __future__ import annotations

import math

import numpy as np

from autobalance.declare import NOT_NEGATIVE, POSITIVE, Key, Values
from autobalance.engines.bearings.keys import ABOVE_ZERO_KELVIN
from autobalance.errors import JobError
from autobalance.types import Array
from autobalance.value_classes import dataclass

GAS_CONSTANT_J_KG_K = 287.05
SUTHERLAND_PA_S, SUTHERLAND_K, AT_K = 1.716e-5, 110.4, 273.15
LAMINAR, TURBULENT = 3.87, 0.146
"""Moment coefficients of both faces of a free disc: 3.87/√Re and 0.146/Re^0.2."""
EDGE_DRAG = (0.6, 1.2)
"""Drag coefficient of a blunt edge: of a plate with rounded corners, and of a square one."""
CORE_SWIRL = 0.4
"""Speed of the air between a disc and its case, over the disc's (Daily & Nece: 0.4 to 0.5)."""
SCATTER = 0.2
"""Share by which measured torques of discs and rims stray from the laws below."""
RIM_STEPS = 60


@dataclass(frozen=True)
class Gas:
    """Gas in the case: density [kg/m³] and dynamic viscosity [Pa s]."""

    density_kg_m3: float
    viscosity_Pa_s: float

    @classmethod
    def air(cls, celsius: float, pressure_bar: float = 1.0, oil_kg_m3: float = 0.0) -> Gas:
        """Return air at a temperature and an absolute pressure, with oil as drops that follow it.

        Examples
        --------
        >>> air = Gas.air(20.0, 1.01325)
        >>> round(air.density_kg_m3, 4), round(air.viscosity_Pa_s * 1e6, 2)
        (1.2041, 18.13)
        """
        kelvin = celsius + AT_K
        thick = SUTHERLAND_PA_S * (kelvin / AT_K) ** 1.5 * (AT_K + SUTHERLAND_K) / (kelvin + SUTHERLAND_K)
        return cls(1e5 * pressure_bar / (GAS_CONSTANT_J_KG_K * kelvin) + oil_kg_m3, thick)


@dataclass(frozen=True)
class TorqueRange:
    """The low and the high end of a torque [N m]."""

    low_N_m: float
    high_N_m: float

    def __add__(self, other: TorqueRange) -> TorqueRange:
        return TorqueRange(self.low_N_m + other.low_N_m, self.high_N_m + other.high_N_m)


def free_disc_coefficients(reynolds: float) -> tuple[float, float]:
    """Return the moment coefficients M/(½ ρ Ω² R⁵) of both faces of a free disc, laminar and turbulent.

    References
    ----------
    .. [1] Th. von Kármán, Über laminare und turbulente Reibung, ZAMM 1 (1921) 233-252; the laminar constant
       by W. G. Cochran (1934).
    """
    return LAMINAR / math.sqrt(reynolds), TURBULENT / reynolds**0.2


def enclosed_disc_coefficient(reynolds: float, gap: float) -> float:
    """Return the moment coefficient of both faces of a disc in a case, ``gap`` away over the radius.

    The largest of four states: laminar and turbulent, with the boundary layers merged and apart.

    References
    ----------
    .. [1] J. W. Daily, R. E. Nece, Chamber dimension effects on induced flow and frictional resistance of
       enclosed rotating disks, J. Basic Eng. 82 (1960) 217-230.
    """
    coefficients = (
        2.0 * math.pi / (gap * reynolds),
        3.70 * gap**0.1 / reynolds**0.5,
        0.080 / (gap ** (1.0 / 6.0) * reynolds**0.25),
        0.102 * gap**0.1 / reynolds**0.2,
    )
    return float(max(coefficients))


def rim_coefficient(reynolds: float) -> float:
    """Return the drag coefficient of a free cylinder's surface: 4/Re, or the turbulent one if it is more.

    References
    ----------
    .. [1] T. Theodorsen, A. Regier, Experiments on drag of revolving disks, cylinders and streamline rods at
       high speeds, NACA Report 793 (1944): 1/√C = −0.6 + 4.07 log₁₀(Re √C).
    """
    laminar = 4.0 / reynolds
    root = 0.05
    for _ in range(RIM_STEPS):
        logarithm = math.log10(max(reynolds * root, 1.5))
        root = 1.0 / max(4.07 * logarithm - 0.6, 0.5)
    return max(laminar, root**2)


def disc_windage(
    radius_m: float, thickness_m: float, gas: Gas, speed_rad_s: float, gap_m: float | None
) -> TorqueRange:
    """Return the torque of a smooth disc, faces and rim; ``gap_m`` to a case on either side, None: free."""
    if speed_rad_s == 0.0:
        return TorqueRange(0.0, 0.0)
    reynolds = gas.density_kg_m3 * speed_rad_s * radius_m**2 / gas.viscosity_Pa_s
    faces = 0.5 * gas.density_kg_m3 * speed_rad_s**2 * radius_m**5
    rim = rim_windage_N_m(radius_m, thickness_m, gas, speed_rad_s)
    free = free_disc_coefficients(reynolds)
    if gap_m is None:
        coefficients = [*free]
    else:
        coefficients = [enclosed_disc_coefficient(reynolds, gap_m / radius_m), max(free)]
    return scattered(faces * min(coefficients) + rim, faces * max(coefficients) + rim)


def scattered(low_N_m: float, high_N_m: float) -> TorqueRange:
    """Return a range widened by what measurements stray from the laws in print."""
    return TorqueRange((1.0 - SCATTER) * low_N_m, (1.0 + SCATTER) * high_N_m)


def rim_windage_N_m(radius_m: float, length_m: float, gas: Gas, speed_rad_s: float) -> float:
    """Return the torque of a cylinder's surface, ½ ρ Ω² R² · C · 2 π R b · R."""
    if speed_rad_s == 0.0:
        return 0.0
    reynolds = gas.density_kg_m3 * speed_rad_s * radius_m**2 / gas.viscosity_Pa_s
    pressure = 0.5 * gas.density_kg_m3 * speed_rad_s**2
    return pressure * 2.0 * math.pi * radius_m**4 * length_m * rim_coefficient(reynolds)


def edge_windage(
    rises_m4: float, thickness_m: float, gas: Gas, speed_rad_s: float, cased: bool
) -> TorqueRange:
    """Return the torque of blunt edges that push the air: ⅛ C ρ Ω² b Σ Δ(r⁴).

    Parameters
    ----------
    rises_m4 : float
        Sum of the rises of r⁴ around the outline, r its largest radius at an angle: the area facing the air.
    thickness_m : float
        b.
    cased : bool
        Whether a case keeps the air: then at the low end it turns with the webs.
    """
    whole = 0.125 * gas.density_kg_m3 * speed_rad_s**2 * thickness_m * rises_m4
    slip = (1.0 - CORE_SWIRL) ** 2 if cased else 1.0
    return TorqueRange(EDGE_DRAG[0] * slip * whole, EDGE_DRAG[1] * whole)


@dataclass(frozen=True)
class WebShape:
    """A web in the air: radius of the disc with its faces' friction, rises of r⁴, thickness."""

    face_radius_m: float
    rises_m4: float
    thickness_m: float

    @classmethod
    def of_outline(cls, radius_m: Array, thickness_m: float) -> WebShape:
        """Return the shape of a web from its largest radius at even angles (n,)."""
        fourth = radius_m**4
        rises = float(np.maximum(np.roll(fourth, -1) - fourth, 0.0).sum())
        return cls(float(np.mean(radius_m**5) ** 0.2), rises, thickness_m)

    def windage(self, gas: Gas, speed_rad_s: float, gap_m: float | None) -> TorqueRange:
        """Return the torque of the web."""
        disc = disc_windage(self.face_radius_m, self.thickness_m, gas, speed_rad_s, gap_m)
        return disc + edge_windage(self.rises_m4, self.thickness_m, gas, speed_rad_s, gap_m is not None)


AIR_KEYS = (
    Key("temperature_C", float, "temperature of the air", ABOVE_ZERO_KELVIN, 20.0),
    Key("pressure_bar", float, "pressure of the air; absolute", POSITIVE, 1.0),
    Key(
        "oil_kg_m3",
        tuple[float, float],
        "smallest and largest mass of oil drops in a volume of the air",
        NOT_NEGATIVE,
        (0.0, 0.0),
    ),
    Key("gap_mm", float, "gap to a case on either side; without it the air is free", POSITIVE, None),
)
"""Keys of the air around a rotor."""


@dataclass(frozen=True)
class Air:
    """Air around a rotor, and the gap to its case; None in free air."""

    temperature_C: float
    pressure_bar: float
    oil_kg_m3: tuple[float, float]
    gap_mm: float | None

    @classmethod
    def of(cls, values: Values, where: str) -> Air:
        """Return the values of a table.

        Raises
        ------
        JobError
            If the range of the oil is upside down.
        """
        low, high = values["oil_kg_m3"]
        if low > high:
            raise JobError(f"{where}.oil_kg_m3 is [{low:g}, {high:g}]; the first must be the lower")
        return cls(values["temperature_C"], values["pressure_bar"], (low, high), values["gap_mm"])


def gases_of(air: Air) -> tuple[Gas, Gas]:
    """Return the gas with the least oil and with the most."""
    low, high = (Gas.air(air.temperature_C, air.pressure_bar, oil) for oil in air.oil_kg_m3)
    return low, high

"""Threshold of oil whirl of a rigid rotor in a bearing."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autobalance.types import Array


@dataclass(frozen=True)
class WhirlThreshold:
    """Critical mass of a rigid rotor on a bearing, and its whirl speed.

    ``critical_mass_kg`` is the bearing's share of the rotor's mass at the threshold; both numbers are
    None where the film is stable with any mass.
    """

    whirl_ratio: float | None
    """Whirl frequency over the speed."""
    critical_mass_kg: float | None


NO_THRESHOLD = WhirlThreshold(None, None)


def whirl_threshold(stiffness_N_m: Array, damping_N_s_m: Array, speed_rad_s: float) -> WhirlThreshold:
    """Return the threshold of oil whirl of a rigid rotor from a film's coefficients.

    On the threshold m ẍ + C ẋ + K x = 0 has a solution that neither grows nor decays, at the whirl speed ω.
    Then m ω² = k = (K_xx C_yy + K_yy C_xx − K_xy C_yx − K_yx C_xy)/(C_xx + C_yy) and ω² det C = (K_xx −
    k)(K_yy − k) − K_xy K_yx.

    Parameters
    ----------
    stiffness_N_m, damping_N_s_m : (2, 2) float
        −∂F_i/∂x_j and −∂F_i/∂ẋ_j.
    speed_rad_s : float
        Of the journal [rad/s].

    References
    ----------
    .. [1] J. W. Lund, The stability of an elastic rotor in journal bearings with flexible, damped supports,
       J. Appl. Mech. 32 (1965) 911-920.
    """
    (kxx, kxy), (kyx, kyy) = stiffness_N_m.tolist()
    (cxx, cxy), (cyx, cyy) = damping_N_s_m.tolist()
    k = (kxx * cyy + kyy * cxx - kxy * cyx - kyx * cxy) / (cxx + cyy)
    square = ((kxx - k) * (kyy - k) - kxy * kyx) / (cxx * cyy - cxy * cyx)
    if not (square > 0.0 and k > 0.0):
        return NO_THRESHOLD
    return WhirlThreshold(math.sqrt(square) / speed_rad_s, k / square)

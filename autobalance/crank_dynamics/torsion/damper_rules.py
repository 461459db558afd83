"""Optimal dampers: Den Hartog's tuned ring and Houdaille's viscous damper."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class DamperRule:
    """Optimal damper of a mass ratio μ.

    ``frequency_ratio`` is the ring's frequency over the system's, 0 without a spring. ``damping_ratio`` is
    c/(2 J_d ω_n). ``peak`` is the largest amplitude over the static one.
    """

    mass_ratio: float
    frequency_ratio: float
    damping_ratio: float
    peak: float

    def n_m_rad(self, inertia_kg_m2: float, frequency_rad_s: float) -> float:
        """Return the ring's spring, J_d (f ω_n)²."""
        return inertia_kg_m2 * (self.frequency_ratio * frequency_rad_s) ** 2

    def n_m_s_rad(self, inertia_kg_m2: float, frequency_rad_s: float) -> float:
        """Return the damper, 2 ζ J_d ω_n."""
        return 2.0 * self.damping_ratio * inertia_kg_m2 * frequency_rad_s


def ring_rule(mass_ratio: float) -> DamperRule:
    """Return the tuned ring: f = 1/(1 + μ), ζ = √(3 μ/(8 (1 + μ)³)), peak √(1 + 2/μ).

    References
    ----------
    J. P. Den Hartog, Mechanical Vibrations, 4th ed. 1956, section 3.3.

    Examples
    --------
    >>> rule = ring_rule(0.2)
    >>> round(rule.frequency_ratio, 4), round(rule.damping_ratio, 4), round(rule.peak, 4)
    (0.8333, 0.2083, 3.3166)
    """
    mu = mass_ratio
    return DamperRule(
        mu, 1.0 / (1.0 + mu), math.sqrt(3.0 * mu / (8.0 * (1.0 + mu) ** 3)), math.sqrt(1.0 + 2.0 / mu)
    )


def viscous_rule(mass_ratio: float) -> DamperRule:
    """Return the untuned viscous damper: ζ = 1/√(2 (1 + μ)(2 + μ)), peak 1 + 2/μ.

    References
    ----------
    J. P. Den Hartog, Mechanical Vibrations, 4th ed. 1956, section 3.3 (Houdaille).

    Examples
    --------
    >>> rule = viscous_rule(1.0)
    >>> round(rule.damping_ratio, 4), rule.peak
    (0.2887, 3.0)
    """
    mu = mass_ratio
    return DamperRule(mu, 0.0, 1.0 / math.sqrt(2.0 * (1.0 + mu) * (2.0 + mu)), 1.0 + 2.0 / mu)

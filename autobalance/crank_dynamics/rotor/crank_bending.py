"""Bending stiffness of a crank throw, as that of an equivalent straight shaft.

A throw is taken as a frame of journal, web, crankpin, web, journal [1]_. A constant bending moment in the
plane of the throw bends both webs across their thickness; one across that plane twists them. Each length
adds its flexibility, corners add none.

References
----------
.. [1] S. Timoshenko, The bending and torsion of multi-throw crankshafts on many supports, Trans. ASME 45
   (1923) 449.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from autobalance.crank_dynamics.torsion.crank_torsion import ThrowShape


@dataclass(frozen=True)
class ThrowBending:
    """EI of a straight shaft of a throw's length and bending flexibility [N·mm²]."""

    in_plane_n_mm2: float
    across_n_mm2: float

    @property
    def mean_n_mm2(self) -> float:
        """EI of an equivalent round shaft: by the mean flexibility of both planes."""
        return 2.0 / (1.0 / self.in_plane_n_mm2 + 1.0 / self.across_n_mm2)


def throw_bending(shape: ThrowShape, youngs_mpa: float, shear_mpa: float) -> ThrowBending:
    """Return the equivalent bending stiffness of a throw.

    Parameters
    ----------
    shape : ThrowShape
        The throw reaches from the middle of one journal to the middle of the next.
    youngs_mpa, shear_mpa : float
        E and G [MPa].

    Examples
    --------
    >>> straight = ThrowShape(50, 0, 40, 50, 0, 40, 1e-9, 10, 50)
    >>> found = throw_bending(straight, 210e3, 80e3)
    >>> bare = 210e3 * math.pi / 64 * 50**4
    >>> round(found.mean_n_mm2 / bare, 3)  # 100 mm long, of which the webs' 20 mm are rigid
    1.25
    """
    journal = math.pi / 64.0 * (shape.journal_mm**4 - shape.journal_bore_mm**4)
    pin = math.pi / 64.0 * (shape.pin_mm**4 - shape.pin_bore_mm**4)
    length = shape.journal_length_mm + shape.pin_length_mm + 2.0 * shape.web_thickness_mm
    shafts = (shape.journal_length_mm / journal + shape.pin_length_mm / pin) / youngs_mpa
    webs = 2.0 * shape.crank_radius_mm
    web = shape.web_breadth_mm * shape.web_thickness_mm**3 / 12.0
    in_plane = shafts + webs / (youngs_mpa * web)
    across = shafts + webs / (shear_mpa * rectangle_torsion_mm4(shape.web_breadth_mm, shape.web_thickness_mm))
    return ThrowBending(length / in_plane, length / across)


def web_bending(shape: ThrowShape, youngs_mpa: float, shear_mpa: float) -> ThrowBending:
    """Return EI of a straight shaft of one web's thickness and bending flexibility."""
    web = shape.web_breadth_mm * shape.web_thickness_mm**3 / 12.0
    twist = rectangle_torsion_mm4(shape.web_breadth_mm, shape.web_thickness_mm)
    share = shape.web_thickness_mm / shape.crank_radius_mm
    return ThrowBending(share * youngs_mpa * web, share * shear_mpa * twist)


def rectangle_torsion_mm4(breadth_mm: float, thickness_mm: float) -> float:
    """Return the torsion constant of a rectangle, to 0.5 %: a b³ (1/3 − 0.21 b/a (1 − b⁴/12a⁴)).

    Examples
    --------
    >>> round(rectangle_torsion_mm4(1.0, 1.0), 3)
    0.141
    """
    a, b = max(breadth_mm, thickness_mm), min(breadth_mm, thickness_mm)
    return a * b**3 * (1.0 / 3.0 - 0.21 * b / a * (1.0 - b**4 / (12.0 * a**4)))

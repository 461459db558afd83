"""Offset grinding of the crankpin: a longer stroke from the same crank; and crankpin overlap."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autobalance.engine.parts import Parts
from autobalance.engine.section_table import cylinder_mass_g
from autobalance.engine.slider_crank import swept_volume_cm3


def crankpin_overlap_mm(main_journal_mm: float, crankpin_mm: float, stroke_mm: float) -> float:
    """Return how far main journal and crankpin overlap seen along the axis; negative: they do not [mm].

    (d_main + d_pin − stroke)/2. More overlap makes a stiffer crank.

    References
    ----------
    Hoem & Røsholm 2016, Sec. 4.3, Fig. 4.13.

    Examples
    --------
    >>> round(crankpin_overlap_mm(28.0, 28.0, 53.8), 3)
    1.1
    """
    return 0.5 * (main_journal_mm + crankpin_mm - stroke_mm)


@dataclass(frozen=True)
class Stroked:
    """A crankpin ground smaller about a centre further out.

    Attributes
    ----------
    crank_radius_mm, stroke_mm : float
        New [mm].
    displacement_cm3 : float
        New, of one cylinder [cm³].
    overlap_mm : float
        New crankpin overlap [mm].
    crankpin_change_g : float
        What grinding takes off the pin, negative [g].
    product_change_g_mm : float
        Change of the counterweight product m_cw r′ that keeps the balance factor, positive: more is needed
        [g·mm].
    factor : float
        Balance factor that the old counterweight gives with the new stroke.
    """

    crank_radius_mm: float
    stroke_mm: float
    displacement_cm3: float
    overlap_mm: float
    crankpin_change_g: float
    product_change_g_mm: float
    factor: float


def stroked(
    *,
    stroke_mm: float,
    bore_mm: float,
    crankpin_mm: float,
    ground_crankpin_mm: float,
    crankpin_width_mm: float,
    main_journal_mm: float,
    density_kg_m3: float,
    parts: Parts,
    factor: float,
) -> Stroked:
    """Return what offset grinding a crankpin does to a crank.

    The pin keeps its outermost line: ground from d₀ to d₁ its centre moves out by (d₀ − d₁)/2, so that
    the stroke grows by d₀ − d₁.

    Parameters
    ----------
    stroke_mm, bore_mm : float
        Old stroke; bore [mm].
    crankpin_mm, ground_crankpin_mm : float
        Diameter before and after [mm].
    crankpin_width_mm : float
        Ground length of the pin [mm].
    main_journal_mm : float
        Diameter [mm].
    density_kg_m3 : float
    parts : Parts
        With the old crankpin as a part of ``crankpin_g``, all of it at the old crank radius.
    factor : float
        Balance factor before.

    References
    ----------
    Hoem & Røsholm 2016, App. C.

    Examples
    --------
    >>> parts = Parts(rotating_g=134.04, reciprocating_g=261.5, crankpin_g=120.0)
    >>> new = stroked(stroke_mm=53.8, bore_mm=76.8, crankpin_mm=28.0, ground_crankpin_mm=26.0,
    ...               crankpin_width_mm=20.0, main_journal_mm=28.0, density_kg_m3=7850.0,
    ...               parts=parts, factor=0.28)
    >>> new.stroke_mm, round(new.displacement_cm3, 1), round(new.overlap_mm, 3)
    (55.8, 258.5, -0.9)
    """
    if not 0.0 < ground_crankpin_mm <= crankpin_mm:
        raise ValueError(
            f"crankpin ground from {crankpin_mm:g} to {ground_crankpin_mm:g} mm;"
            " the new diameter must be > 0 and no larger than the old"
        )
    new_stroke = stroke_mm + crankpin_mm - ground_crankpin_mm
    old_radius, new_radius = 0.5 * stroke_mm, 0.5 * new_stroke
    old_pin = cylinder_mass_g(crankpin_mm, crankpin_width_mm, density_kg_m3)
    new_pin = cylinder_mass_g(ground_crankpin_mm, crankpin_width_mm, density_kg_m3)
    if parts.crankpin_g < old_pin:
        raise ValueError(
            f"crankpin parts weigh {parts.crankpin_g:g} g; must hold the pin before grinding, {old_pin:.1f} g"
        )
    product = parts.bob_weight_g(factor) * old_radius
    # What else is on the pin stays where it was; the pin and the rods move out.
    moved = (parts.crankpin_g - old_pin) * old_radius
    moved += (new_pin + parts.rods * parts.rotating_g) * new_radius
    reciprocating = parts.reciprocating_on_throw_g * new_radius
    return Stroked(
        new_radius,
        new_stroke,
        swept_volume_cm3(bore_mm, new_stroke),
        crankpin_overlap_mm(main_journal_mm, ground_crankpin_mm, new_stroke),
        new_pin - old_pin,
        moved + factor * reciprocating - product,
        (product - moved) / reciprocating if reciprocating else math.nan,
    )


def stroke_for_displacement_mm(displacement_cm3: float, bore_mm: float) -> float:
    """Return the stroke that gives a cylinder a displacement [mm].

    Examples
    --------
    >>> round(stroke_for_displacement_mm(297.0, 76.8), 1)
    64.1
    """
    return displacement_cm3 / swept_volume_cm3(bore_mm, 1.0)

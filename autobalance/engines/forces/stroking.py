"""A crank on a stroked radius, and the substitute rotor for a balancing machine."""

from __future__ import annotations

import math

from autobalance.running_gear.conrod import cylinder_mass_g
from autobalance.running_gear.parts import Parts
from autobalance.running_gear.slider_crank import swept_volume_cm3
from autobalance.units import G_MM2_PER_KG_MM2, G_PER_MM3_PER_KG_M3, STEEL_KG_M3
from autobalance.value_classes import dataclass

# Stroke of a crank: crankpin overlap, offset grinding of the crankpin, stroke for a displacement.


def crankpin_overlap_mm(main_journal_mm: float, crankpin_mm: float, stroke_mm: float) -> float:
    """Return the overlap of main journal and crankpin seen along the axis, (d_main + d_pin − s)/2 [mm].

    More overlap makes a stiffer crank.

    Parameters
    ----------
    main_journal_mm, crankpin_mm, stroke_mm : float
        Diameters and stroke [mm]; a negative result: they do not overlap.

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


def stroked_crank(
    stroke_mm: float,
    bore_mm: float,
    crankpin_mm: float,
    ground_crankpin_mm: float,
    crankpin_width_mm: float,
    main_journal_mm: float,
    rotating_g: float,
    reciprocating_g: float,
    crankpin_g: float,
    factor: float,
    density_kg_m3: float = STEEL_KG_M3,
) -> Stroked:
    """Return a crank after offset grinding of its crankpin: stroke s + d₀ − d₁.

    The pin keeps its outermost line: ground from d₀ to d₁ its centre moves out by (d₀ − d₁)/2.

    Parameters
    ----------
    stroke_mm, bore_mm, crankpin_mm, ground_crankpin_mm, crankpin_width_mm, main_journal_mm : float
        Old stroke, bore, diameter of the crankpin before and after, its ground length, diameter of the main
        journal [mm].
    rotating_g, reciprocating_g, crankpin_g : float
        Parts of the throw, the old crankpin in ``crankpin_g``, all of it at the old crank radius [g].
    factor : float
        Balance factor before.
    density_kg_m3 : float

    References
    ----------
    Hoem & Røsholm 2016, App. C, Fig. 7.3.

    Examples
    --------
    >>> crank = stroked_crank(53.8, 76.8, 28.0, 26.0, 20.0, 28.0, 134.04, 261.5, 120.0, 0.28)
    >>> crank.stroke_mm, round(crank.displacement_cm3, 1), round(crank.overlap_mm, 3)
    (55.8, 258.5, -0.9)
    """
    if not 0.0 < ground_crankpin_mm <= crankpin_mm:
        raise ValueError(
            f"crankpin ground from {crankpin_mm:g} to {ground_crankpin_mm:g} mm;"
            " the new diameter must be > 0 and no larger than the old"
        )
    parts = Parts(rotating_g, reciprocating_g, crankpin_g)
    new_stroke = stroke_mm + crankpin_mm - ground_crankpin_mm
    old_radius, new_radius = 0.5 * stroke_mm, 0.5 * new_stroke
    old_pin = cylinder_mass_g(crankpin_mm, crankpin_width_mm, density_kg_m3)
    new_pin = cylinder_mass_g(ground_crankpin_mm, crankpin_width_mm, density_kg_m3)
    if crankpin_g < old_pin:
        raise ValueError(
            f"crankpin parts weigh {crankpin_g:g} g; must hold the pin before grinding, {old_pin:.1f} g"
        )
    product = parts.bob_weight_g(factor) * old_radius
    # What else is on the pin stays where it was; the pin and the rods move out.
    moved = (crankpin_g - old_pin) * old_radius
    moved += (new_pin + rotating_g) * new_radius
    reciprocating = reciprocating_g * new_radius
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

    Parameters
    ----------
    displacement_cm3, bore_mm : float
        [cm³, mm]

    References
    ----------
    Hoem & Røsholm 2016, App. C.

    Examples
    --------
    >>> round(stroke_for_displacement_mm(297.0, 76.8), 1)
    64.1
    """
    return displacement_cm3 / swept_volume_cm3(bore_mm, 1.0)


# A plain disc on a shaft that has the inertia of a crank, for a test bench.


@dataclass(frozen=True)
class MidspanDisc:
    """A disc in the middle of a shaft of one material."""

    disc_mm: float
    shaft_mm: float
    length_mm: float
    thickness_mm: float
    shaft_each_side_mm: float
    mass_g: float
    polar_inertia_kg_mm2: float


def substitute_rotor(
    polar_inertia_kg_mm2: float,
    disc_mm: float,
    shaft_mm: float,
    length_mm: float,
    density_kg_m3: float = STEEL_KG_M3,
) -> MidspanDisc:
    """Return a disc on a shaft that has a crank's polar inertia: t = (32 J/(π ρ) − d₂⁴ L₁)/(d₁⁴ − d₂⁴).

    Parameters
    ----------
    polar_inertia_kg_mm2 : float
        Wanted [kg·mm²].
    disc_mm, shaft_mm, length_mm : float
        Diameters d₁ and d₂, and whole length L₁ [mm].
    density_kg_m3 : float

    Raises
    ------
    ValueError
        If there is no such disc.

    References
    ----------
    Hoem & Røsholm 2016, App. E, Eq. 7.7 to 7.9; Table 7.2's thickness belongs to a disc of 100 mm: as printed
    J is 7.7 % low.

    Examples
    --------
    >>> round(substitute_rotor(2847.335, 98.0, 20.0, 188.0).thickness_mm, 3)
    39.799
    """
    if not 0.0 < shaft_mm < disc_mm:
        raise ValueError(
            f"a disc of {disc_mm:g} mm on a shaft of {shaft_mm:g} mm; the disc must be the larger"
        )
    inertia = polar_inertia_kg_mm2 * G_MM2_PER_KG_MM2
    fourth = 32.0 * inertia / (density_kg_m3 * G_PER_MM3_PER_KG_M3 * math.pi)
    thickness = (fourth - shaft_mm**4 * length_mm) / (disc_mm**4 - shaft_mm**4)
    if not 0.0 < thickness <= length_mm:
        raise ValueError(
            f"the disc would have to be {thickness:.3f} mm thick; must be above 0 and at most the length,"
            f" {length_mm:g} mm"
        )
    return disc_rotor(disc_mm, shaft_mm, length_mm, thickness, density_kg_m3)


def disc_rotor(
    disc_mm: float, shaft_mm: float, length_mm: float, thickness_mm: float, density_kg_m3: float = STEEL_KG_M3
) -> MidspanDisc:
    """Return mass and polar inertia of a disc in the middle of a shaft: J = ρ π/32 (d₁⁴ t + d₂⁴ (L₁ − t)).

    Parameters
    ----------
    disc_mm, shaft_mm, length_mm, thickness_mm : float
        Diameters d₁ and d₂, whole length L₁, thickness of the disc t [mm].
    density_kg_m3 : float

    References
    ----------
    Hoem & Røsholm 2016, App. E, Table 7.2.

    Examples
    --------
    >>> round(disc_rotor(98.0, 20.0, 188.0, 39.799).polar_inertia_kg_mm2, 1)
    2847.4
    """
    each_side = 0.5 * (length_mm - thickness_mm)
    disc = cylinder_mass_g(disc_mm, thickness_mm, density_kg_m3)
    shaft = cylinder_mass_g(shaft_mm, 2.0 * each_side, density_kg_m3)
    inertia = (disc * disc_mm**2 + shaft * shaft_mm**2) / 8.0
    return MidspanDisc(
        disc_mm, shaft_mm, length_mm, thickness_mm, each_side, disc + shaft, inertia / G_MM2_PER_KG_MM2
    )

"""Formulas of the crankshaft's stroke: overlap, stroking, displacement."""

from __future__ import annotations

from autobalance.engine import stroking
from autobalance.engine.parts import Parts


def crankpin_overlap_mm(main_journal_mm: float, crankpin_mm: float, stroke_mm: float) -> float:
    """Return how far main journal and crankpin overlap seen along the axis, (d_main + d_pin − s)/2 [mm].

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
    return stroking.crankpin_overlap_mm(main_journal_mm, crankpin_mm, stroke_mm)


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
    density_kg_m3: float = 7850.0,
) -> stroking.Stroked:
    """Return what offset grinding of the crankpin makes of a crank: stroke s + d₀ − d₁.

    Parameters
    ----------
    stroke_mm, bore_mm, crankpin_mm, ground_crankpin_mm, crankpin_width_mm, main_journal_mm : float
        [mm]
    rotating_g, reciprocating_g, crankpin_g : float
        Parts of the throw, the old crankpin in ``crankpin_g`` [g].
    factor : float
        Balance factor before.
    density_kg_m3 : float

    References
    ----------
    Hoem & Røsholm 2016, App. C, Fig. 7.3.

    Examples
    --------
    >>> stroked_crank(53.8, 76.8, 28.0, 26.0, 20.0, 28.0, 134.04, 261.5, 120.0, 0.28).stroke_mm
    55.8
    """
    return stroking.stroked(
        stroke_mm=stroke_mm,
        bore_mm=bore_mm,
        crankpin_mm=crankpin_mm,
        ground_crankpin_mm=ground_crankpin_mm,
        crankpin_width_mm=crankpin_width_mm,
        main_journal_mm=main_journal_mm,
        density_kg_m3=density_kg_m3,
        parts=Parts(rotating_g, reciprocating_g, crankpin_g),
        factor=factor,
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
    return stroking.stroke_for_displacement_mm(displacement_cm3, bore_mm)

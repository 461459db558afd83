"""Main journals and an axis that the rules of recognition leave open."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from autobalance.crank.anatomy import Anatomy, Cylinder, Doubt, MainJournal, Pin
from autobalance.crank.recognition.cylinder_runs import SAME_RADIUS, CylinderRun
from autobalance.crank.recognition.journal_rules import SAME_THICKNESS
from autobalance.crank.recognition.layout import JournalLayout
from autobalance.types import Array

CENTRE_DIGITS, SIZE_DIGITS = 5, 4
"""Decimals of a line to paste: an axis 0.01 µm off costs less than a thousandth of any permissible value."""


def journal_doubts(
    journals: Sequence[MainJournal],
    others: Sequence[CylinderRun | None],
    cylinders: Sequence[Cylinder],
    to_rotor: Array,
    to_file: Array,
) -> tuple[Doubt, ...]:
    """Return a doubt for each main journal for which another cylinder may be meant.

    The line that takes the other one takes it at the other end, too, if the same choice is left open there.

    Parameters
    ----------
    journals : sequence of MainJournal
        In the rotor frame.
    others : sequence of CylinderRun or None
        The other cylinder for each journal, in the turned axes; empty without doubts.
    cylinders : sequence of Cylinder
        All of the crank.
    to_rotor, to_file : (4, 4) float
        From the turned axes to the rotor frame, and from that to the file's.
    """
    pairs = [
        (journal, None if run is None else _listed(run, cylinders, to_rotor))
        for journal, run in zip(journals, others or [None] * len(journals), strict=True)
    ]
    doubts = []
    for journal, other in pairs:
        if other is not None:
            meant = [
                there if there is not None and _alike((journal, other), (each, there)) else each
                for each, there in pairs
            ]
            doubts.append(Doubt("main_journal", journal.number, journal, other, _setting(meant, to_file)))
    return tuple(doubts)


def _alike(pair: tuple[Pin, Pin], other: tuple[Pin, Pin]) -> bool:
    """Return whether two choices are between cylinders of the same sizes, as at two equal ends of a crank."""
    return all(
        abs(a.diameter_mm - b.diameter_mm) < SAME_THICKNESS * a.diameter_mm
        for a, b in zip(pair, other, strict=True)
    )


def axis_doubts(found: Anatomy, layout: JournalLayout, to_rotor: Array) -> tuple[Doubt, ...]:
    """Return the doubt about the axis, if a crankpin's cylinder or bore may be the shaft's instead.

    ``to_rotor`` (4, 4) leads from the layout's axes to the rotor frame.
    """
    run = layout.other_axis
    if run is None:
        return ()
    centre = to_rotor[:3, :3] @ np.array([*run.centre, run.z_mid]) + to_rotor[:3, 3]
    place = (found.rotor_to_file @ np.array([*centre, 1.0]))[:3]
    point = ", ".join(_digits(float(value), CENTRE_DIGITS) for value in place)
    setting = layout.axis_setting or f"crankshaft.axis_point_mm = [{point}]"
    other = Pin(centre, 2.0 * run.radius, run.width)
    return (Doubt("axis", 1, found.main_journals[0], other, setting),)


def _listed(run: CylinderRun, cylinders: Sequence[Cylinder], to_rotor: Array) -> Pin:
    """Return the cylinder of the crank that a run is; it was fitted again since."""
    centre = to_rotor[:3, :3] @ np.array([*run.centre, run.z_mid]) + to_rotor[:3, 3]
    own = Pin(centre, 2.0 * run.radius, run.width)
    there = [
        each
        for each in cylinders
        if each.kind == "outside"
        and abs(each.diameter_mm - own.diameter_mm) < SAME_RADIUS * own.diameter_mm
        and each.z_range_mm[0] < centre[2] < each.z_range_mm[1]
    ]
    return min(there, key=lambda each: abs(float(each.centre_mm[2] - centre[2])), default=own)


def _setting(journals: Sequence[Pin], to_file: Array) -> str:
    """Return the line of a job that states main journals, in the file's own axes."""
    entries = []
    for pin in journals:
        centre = to_file[:3, :3] @ pin.centre_mm + to_file[:3, 3]
        place = ", ".join(_digits(float(value), CENTRE_DIGITS) for value in centre)
        sizes = (_digits(value, SIZE_DIGITS) for value in (pin.diameter_mm, pin.width_mm))
        diameter, width = sizes
        entries.append(f"{{ centre_mm = [{place}], diameter_mm = {diameter}, width_mm = {width} }}")
    return f"crankshaft.main_journals = [{', '.join(entries)}]"


def _digits(value: float, digits: int) -> str:
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("", "-0") else text

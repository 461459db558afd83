"""Round holes along the crank axis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from autobalance.crank.recognition.circles import distances
from autobalance.crank.recognition.cylinder_runs import CylinderRun, Link, run_of_chain
from autobalance.crank.recognition.section_stack import CrossSection, SectionStack, encloses

MAX_CROSSING = 2.0
"""Drillings that meet a bore hide its circle over at most so many of its radii, slanting ones too ..."""
LEAST_OPEN = 0.9
"""... and leave it open to at least this share of its radius."""
WALL_LEFT = 1.02
"""Largest distance from the middle of a bore, in radii, to the remaining wall next to a bore across."""


def bore_runs(long: SectionStack, rounding_mm: float) -> list[CylinderRun]:
    """Return the round holes along the axis, by increasing z."""
    chains: list[list[Link]] = []
    for place, section in enumerate(long.sections):
        for piece in section.pieces:
            for bore in piece.bores:
                here = Link(place, bore.centre, bore.radius)
                for chain in reversed(chains):
                    if here.continues(chain[0], piece.rough_mm) and _follows(long, chain[-1], here):
                        chain.append(here)
                        break
                else:
                    chains.append([here])
    runs = [_bore(long, chain, rounding_mm) for chain in chains]
    return sorted((run for run in runs if run is not None), key=lambda run: run.z_mid)


def _follows(long: SectionStack, last: Link, here: Link) -> bool:
    """Return whether a hole continues from one section to another: drillings that meet it may lie between."""
    between = long.sections[last.place + 1 : here.place]
    gap = long.sections[here.place].z_mm - long.sections[last.place].z_mm
    if here.place == last.place or (between and gap > MAX_CROSSING * here.radius):
        return False
    return all(_is_open(section, here) for section in between)


def _is_open(section: CrossSection, bore: Link) -> bool:
    """Return whether a section has a hole about a bore's middle that is at least as wide, but not round."""
    return _is_cut_open(section, bore) or any(
        not circles
        and encloses(hole, bore.centre)
        and float(distances(hole, bore.centre).min()) > LEAST_OPEN * bore.radius
        for piece in section.pieces
        for hole, circles in zip(piece.holes, piece.bores_of_holes, strict=True)
    )


def _is_cut_open(section: CrossSection, bore: Link) -> bool:
    """Return whether a part of a bore's wall is left, but no hole: a bore across cut the metal around it."""
    if any(encloses(piece.outline, bore.centre) for piece in section.pieces):
        return False
    nearest = min((float(distances(p.outline, bore.centre).min()) for p in section.pieces), default=0.0)
    return LEAST_OPEN * bore.radius < nearest < WALL_LEFT * bore.radius


def _bore(long: SectionStack, chain: Sequence[Link], rounding_mm: float) -> CylinderRun | None:
    if long.blur_mm == 0.0:
        return run_of_chain(long, chain, rounding_mm, 0.0)
    low, high = (long.sections[link.place].z_mm for link in (chain[0], chain[-1]))
    centre = np.median([link.centre for link in chain], axis=0)
    return CylinderRun(centre, float(np.median([link.radius for link in chain])), low, high)

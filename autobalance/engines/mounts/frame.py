"""A flexible frame below an engine's mounts, by its modes from a file of an FE program: CSV or UFF 55.

With mass-normalised shapes Φ the frame's coordinates η follow η̈ + ω_m² (1 + 2iζ) η = Φᵀ f, with f the mounts'
forces on it. A mount stretches by what its engine end moves more than its frame end, A q − Φ η.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from autobalance.errors import JobError, file_errors
from autobalance.types import Array

COLUMNS = ("mode", "frequency_hz", "x_mm", "y_mm", "z_mm", "ux", "uy", "uz")
PER_ROOT_G = 1.0 / math.sqrt(1e3)
"""A mass-normalised shape of 1/√kg in 1/√g."""
MM_PER_UNIT = {"m": 1e3, "mm": 1.0}
G_PER_MASS_UNIT = {"m": 1e3, "mm": 1e6}
"""Mass unit beside N, s and the length: kg with m, tonnes with mm."""


@dataclass(frozen=True, eq=False)
class FrameModes:
    """Modes of a frame: frequencies (m,) [rad/s], damping ratios (m,), nodes (p, 3) [mm], shapes (m, p, 3).

    Shapes are mass-normalised, in 1/√g.
    """

    frequency_rad_s: Array
    damping_ratio: Array
    places_mm: Array
    shapes: Array

    def at(self, place_mm: Array, within_mm: float, what: str) -> Array:
        """Return the shapes (3, m) at the node next to a place.

        Raises
        ------
        JobError
            If no node is so near.
        """
        apart = np.linalg.norm(self.places_mm - np.asarray(place_mm), axis=1)
        nearest = int(np.argmin(apart))
        if apart[nearest] > within_mm:
            at = ", ".join(f"{each:.4g}" for each in self.places_mm[nearest])
            raise JobError(
                f"mounts.frame: no node within {within_mm:g} mm of {what}; the nearest is at [{at}],"
                f" {apart[nearest]:.4g} mm away"
            )
        return np.asarray(self.shapes[:, nearest].T)


def read_modes(path: Path, unit: str, damping_ratio: float) -> FrameModes:
    """Return the modes of a file: CSV by its ending, else UFF.

    Parameters
    ----------
    path : Path
    unit : {"m", "mm"}
        Length of a UFF file without its units (164).
    damping_ratio : float
        Of modes without their own.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it has no modes, or nodes without a place.
    """
    with file_errors(f"read the modes of the frame {path.name}"):
        text = path.read_text(encoding="utf-8", errors="replace")
    try:
        modes = (
            _csv(text, damping_ratio) if path.suffix.lower() == ".csv" else _uff(text, unit, damping_ratio)
        )
    except (KeyError, IndexError, ValueError) as error:
        raise JobError(f"{path.name} is not a readable file of modes: {error}") from None
    finite = all(np.isfinite(each).all() for each in (modes.frequency_rad_s, modes.places_mm, modes.shapes))
    if not len(modes.frequency_rad_s) or not finite or (modes.damping_ratio < 0.0).any():
        raise JobError(f"{path.name} has no modes, or numbers that are not finite, or negative damping")
    return modes


def _csv(text: str, usual: float) -> FrameModes:
    rows = list(csv.DictReader(text.splitlines()))
    missing = [name for name in COLUMNS if not rows or name not in rows[0]]
    if missing:
        raise ValueError(f"columns {', '.join(missing)} are missing")
    by_mode: dict[str, list[dict[str, str]]] = {}
    for row in rows:
        by_mode.setdefault(row["mode"], []).append(row)
    first = next(iter(by_mode.values()))
    places = np.array([[float(row[name]) for name in COLUMNS[2:5]] for row in first])
    shapes = []
    for mode, listed in by_mode.items():
        own = np.array([[float(row[name]) for name in COLUMNS[2:5]] for row in listed])
        if own.shape != places.shape or np.abs(own - places).max() > 1e-6:
            raise ValueError(f"mode {mode} has other nodes than the first; each needs all, in one order")
        shapes.append([[float(row[name]) for name in COLUMNS[5:]] for row in listed])
    damping = [float(listed[0].get("damping_ratio") or usual) for listed in by_mode.values()]
    frequency = [float(listed[0]["frequency_hz"]) for listed in by_mode.values()]
    return FrameModes(
        2.0 * np.pi * np.array(frequency), np.array(damping), places, np.array(shapes) * PER_ROOT_G
    )


def _blocks(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the datasets of a universal file: number and lines."""
    inside: list[str] | None = None
    for line in text.splitlines():
        if line.strip() == "-1":
            if inside:
                yield int(inside[0].split()[0]), inside[1:]
            inside = [] if inside is None else None
        elif inside is not None:
            inside.append(line)


def _numbers(line: str) -> list[float]:
    return [float(word) for word in line.replace("D", "E").replace("d", "e").split()]


def _uff(text: str, unit: str, usual: float) -> FrameModes:
    mm, gram = MM_PER_UNIT[unit], G_PER_MASS_UNIT[unit]
    nodes: dict[int, list[float]] = {}
    modes: list[tuple[float, float, float, dict[int, list[float]]]] = []
    for number, lines in _blocks(text):
        if number == 164:
            length, force = _numbers(lines[1])[:2]
            mm, gram = 1e3 / length, 1e3 * length / force
        elif number == 15:
            nodes |= {int(line.split()[0]): _numbers(line)[4:7] for line in lines if line.strip()}
        elif number == 2411:
            pairs = zip(lines[::2], lines[1::2], strict=False)
            nodes |= {int(head.split()[0]): _numbers(place)[:3] for head, place in pairs}
        elif number == 55:
            modes.append(_mode(lines, usual))
    if not modes:
        raise ValueError("it has no dataset 55 of normal modes")
    labels = sorted(modes[0][3])
    unplaced = [label for label in labels if label not in nodes]
    if unplaced:
        raise ValueError(f"nodes {unplaced[:5]} of dataset 55 have no place (dataset 15 or 2411)")
    shapes = [
        np.array([of[label][:3] for label in labels]) / math.sqrt(mass * gram) for _, _, mass, of in modes
    ]
    return FrameModes(
        2.0 * np.pi * np.array([frequency for frequency, *_ in modes]),
        np.array([damping for _, damping, *_ in modes]),
        np.array([nodes[label] for label in labels]) * mm,
        np.array(shapes),
    )


def _mode(lines: Sequence[str], usual: float) -> tuple[float, float, float, dict[int, list[float]]]:
    """Return frequency [Hz], damping ratio, modal mass and shape by node of a dataset 55."""
    _, analysis, _, _, data_type, values = (int(word) for word in lines[5].split()[:6])
    if analysis != 2 or data_type != 2:
        raise ValueError("dataset 55 is not of real normal modes")
    frequency, mass, viscous, hysteretic = _numbers(lines[7])[:4]
    if not mass > 0.0:
        raise ValueError(f"a mode at {frequency:g} Hz has a modal mass of {mass:g}; must be > 0")
    damping = viscous or hysteretic / 2.0 or usual
    shape: dict[int, list[float]] = {}
    at = 8
    while at < len(lines) and lines[at].strip():
        label = int(lines[at].split()[0])
        row: list[float] = []
        while len(row) < values:
            at += 1
            row += _numbers(lines[at])
        shape[label] = row
        at += 1
    return frequency, damping, mass, shape

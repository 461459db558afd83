"""Read a chain's file for ``torsion``. SI units out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.crank_dynamics.torsion.chain import TorsionChain
from autobalance.crank_dynamics.torsion.input import DAMPING_RATIO, INERTIA, SHARED, SPRING, question_of
from autobalance.crank_dynamics.torsion.model import TorsionQuestion
from autobalance.declare import FILLED, Key, Values
from autobalance.errors import JobError
from autobalance.toml_files.keys import read_document
from autobalance.units import KG_M2_PER_KG_MM2, M_PER_MM
from autobalance.value_classes import dataclass

CHAIN = (
    *SHARED,
    Key("inertia", says="stations in order", keys=INERTIA, many=True),
    Key("spring", says="springs between one station and the next", keys=SPRING, many=True, default=()),
    Key("torsion", says="settings of the calculation", keys=(DAMPING_RATIO,), default=FILLED),
)
"""Every key of a chain's file."""


@dataclass(frozen=True, eq=False)
class ChainFile:
    """A chain with the questions about it; ``filled`` is the file as read, defaults filled in."""

    question: TorsionQuestion
    chain: TorsionChain
    names: tuple[str, ...]
    diameters_m: tuple[float | None, ...]
    filled: Values


def read_chain(source: str | Path | Mapping[str, Any]) -> ChainFile:
    """Read a chain's file, or a dict of its structure.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not TOML, or a key is unknown, missing, of the wrong type or impossible.
    """
    return read_document(source, "torsion file", CHAIN, _chain)


def _chain(filled: Values) -> ChainFile:
    inertias, springs = filled["inertia"], filled["spring"]
    if len(springs) != len(inertias) - 1:
        raise JobError(
            f"there are {len(springs)} [[spring]] tables; {len(inertias)} inertias need {len(inertias) - 1}"
        )
    chain = TorsionChain(
        KG_M2_PER_KG_MM2 * np.array([each["kg_mm2"] for each in inertias]),
        np.array([each["N_m_rad"] for each in springs]),
        np.array([each["damping_N_m_s_rad"] for each in inertias]),
        np.array([each["damping_N_m_s_rad"] for each in springs]),
    )
    diameters = tuple(None if d is None else M_PER_MM * d for d in (s["diameter_mm"] for s in springs))
    names = tuple(each["name"] or f"station {n}" for n, each in enumerate(inertias, 1))
    branched = sum(len(each["inertia"]) for each in filled["branch"])
    return ChainFile(question_of(filled, len(inertias) + branched), chain, names, diameters, filled)

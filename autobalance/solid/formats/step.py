"""STEP: true surfaces, which the CAD kernel reads and writes; here it only says so."""

from __future__ import annotations

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.formats.format import Format
from autobalance.solid.formats.raw import Raw
from autobalance.solid.mesh.mesh import Floats, Indices


def _no_mesh(data: bytes) -> Raw:
    raise FormatError("a STEP file holds exact surfaces, no mesh")


def _no_step(vertices: Floats, triangles: Indices, mm_per_unit: float) -> bytes:
    raise FormatError("a mesh cannot be written as STEP; needed stl")


STEP = Format(
    "step",
    ("step", "stp"),
    _no_mesh,
    _no_step,
    np.float64,
    carries_unit=True,
    names_bodies=True,
    exact=True,
)

"""A crank for the page's view and the notebook's: triangles with their parts, packed as plain binary."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from autobalance import registry
from autobalance.report.pictures.picture import crank_picture
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.balancing.measured import Crank
    from autobalance.crank.anatomy import Anatomy, Face, Pin
    from autobalance.crank.recognition.candidates import CylinderCandidate
    from autobalance.verbs.balance import BalanceResult
    from autobalance.verbs.inspect import InspectResult


# Numbers for the page as plain binary: a head in JSON, then arrays, little-endian.


GRID = 1023
"""Steps of a coordinate along the curve that sorts triangles."""


def packed(head: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return a head and arrays as one buffer.

    Its first four bytes are the length of the head. The head's ``arrays`` has for each name the place of its
    first byte behind the head, the number of values and their kind (``f4``, ``u4``, ``u2``, ``u1``).

    Examples
    --------
    >>> data = packed({"made": 1}, {"depths": np.array([1, 2], "<u2")})
    >>> length = int.from_bytes(data[:4], "little")
    >>> json.loads(data[4 : 4 + length])["arrays"], len(data) - 4 - length
    ({'depths': [0, 2, 'u2']}, 4)
    """
    places: dict[str, list[Any]] = {}
    parts: list[bytes] = []
    size = 0
    for name, array in arrays.items():
        data = np.ascontiguousarray(array).tobytes()
        data += b"\0" * (-len(data) % 4)
        places[name] = [size, int(array.size), array.dtype.str.lstrip("<|")]
        parts.append(data)
        size += len(data)
    text = json.dumps({**head, "arrays": places}, allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<I", len(text)) + text + b"".join(parts)


def along_a_curve(points: Array) -> Indices:
    """Return the order (n,) in which points (n, 3) lie along a curve that fills space (Morton's).

    Neighbours on the curve are near each other, so that runs of it have small boxes: rays are shot through
    those, without a tree.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    cells = (points - low) * (GRID / np.maximum(high - low, 1e-12))
    code = np.zeros(len(points), dtype=np.uint32)
    for axis in range(3):
        code |= _spread(cells[:, axis].astype(np.uint32)) << np.uint32(axis)
    return np.argsort(code, kind="stable").astype(np.int64)


def _spread(value: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """Return ten bits with two empty ones behind each."""
    for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
        value = (value | (value << np.uint32(shift))) & np.uint32(mask)
    return value


# A crank for the page's view: triangles with their parts; or what a run left of one.


Part = dict[str, Any]
CREASE_COSINE = math.cos(math.radians(28.0))
"""Edges are drawn where two triangles meet at more than this."""
ON_CYLINDER = 0.01
"""A triangle is on a cylinder when its corners are off by less than this share of the radius."""


def recognised_mesh(result: InspectResult) -> bytes:
    """Return the crank of an inspection as a buffer."""
    from autobalance.crank.recognition.candidates import cylinder_candidates

    measured = result.crank.measured
    mesh, anatomy = measured.source.solid.mesh, measured.anatomy
    others = cylinder_candidates(mesh, anatomy.file_to_rotor[2, :3])
    return crank_mesh(mesh, anatomy, result.faces, others)


def crank_mesh(
    mesh: Mesh, anatomy: Anatomy, faces: Sequence[Face], others: Sequence[CylinderCandidate]
) -> bytes:
    """Return a recognised crank as a buffer: corners, triangles, and the part of each triangle.

    Parts are numbered from 1, as the head lists them: faces, journals and crankpins, and the cylinders that
    are neither (``others``, without round webs). 0 is not a part.
    """
    frame = anatomy.file_to_rotor
    corners = mesh.vertices @ frame[:3, :3].T + frame[:3, 3]
    marks = _Marks(corners, mesh.triangles)
    for number, face in enumerate(faces, 1):
        marks.add({"kind": "face", "number": number, "id": face.id}, face.triangles)
    pins: list[Pin] = []
    for journal in anatomy.main_journals:
        marks.add_cylinder({"kind": "main_journal", "number": journal.number}, journal, frame)
        pins.append(journal)
    for throw in anatomy.throws:
        marks.add_cylinder({"kind": "throw", "number": throw.number}, throw.crankpin, frame)
        pins.append(throw.crankpin)
    for other in others:
        pin = other.moved(frame)
        within = any(web.z_min_mm < pin.centre_mm[2] < web.z_max_mm for web in anatomy.webs)
        if not within and not any(_same(pin, each) for each in pins):
            marks.add_cylinder({"kind": "cylinder", "number": len(marks.parts) + 1}, pin, frame)
    return marks.packed({"frame": "rotor", "anatomy": _coloured(anatomy)})


def _coloured(anatomy: Anatomy) -> dict[str, list[list[float]]]:
    """Return the places of the parts that have separate colours, rotor frame [mm].

    Journals and crankpins: x, y, z of the centre, radius, width; webs with counterweights: z from and to, and
    the direction (2,) away from the crankpin, in which the counterweight begins at the crank axis.
    """
    from autobalance.crank.sections import away_from_crankpin

    def round_(pin: Pin) -> list[float]:
        return [*map(float, pin.centre_mm), 0.5 * float(pin.diameter_mm), float(pin.width_mm)]

    weights = [
        [float(web.z_min_mm), float(web.z_max_mm), *map(float, away_from_crankpin(web, anatomy))]
        for web in anatomy.webs
        if web.counterweight
    ]
    return {
        "journals": [round_(journal) for journal in anatomy.main_journals],
        "pins": [round_(throw.crankpin) for throw in anatomy.throws],
        "weights": weights,
    }


def bare_mesh(mesh: Mesh, others: Sequence[CylinderCandidate]) -> bytes:
    """Return a solid that no crank was recognised in: in file coordinates, with the cylinders in it."""
    marks = _Marks(mesh.vertices, mesh.triangles)
    for number, other in enumerate(others, 1):
        marks.add_on({"kind": "cylinder", "number": number}, other)
    return marks.packed({"frame": "file"})


def _same(one: Pin, other: Pin) -> bool:
    near = float(np.linalg.norm(one.centre_mm[:2] - other.centre_mm[:2])) < 0.05 * other.diameter_mm
    overlap = abs(float(one.centre_mm[2] - other.centre_mm[2])) < 0.5 * (one.width_mm + other.width_mm)
    return near and overlap and abs(one.diameter_mm - other.diameter_mm) < 0.02 * other.diameter_mm


class _Marks:
    """Collects the part of each triangle; the first part that claims one has it."""

    def __init__(self, corners: Array, triangles: Indices) -> None:
        self.corners, self.triangles = corners, triangles
        self.part = np.zeros(len(triangles), dtype="<u2")
        self.parts: list[Part] = []

    def add(self, part: Part, rows: Indices) -> None:
        self.parts.append(part)
        mine = rows[self.part[rows] == 0]
        self.part[mine] = len(self.parts)

    def add_cylinder(self, part: Part, pin: Pin, frame: Array) -> None:
        """Mark a cylinder along z, in file coordinates too, as an override of the job needs it."""
        back = frame[:3, :3].T @ (pin.centre_mm - frame[:3, 3])
        fields = {
            "file_centre_mm": [float(value) for value in back],
            "diameter_mm": float(pin.diameter_mm),
            "width_mm": float(pin.width_mm),
        }
        axis = np.array([0.0, 0.0, 1.0])
        self.add({**part, **fields}, self._on(pin.centre_mm, axis, pin.diameter_mm, pin.width_mm))

    def add_on(self, part: Part, other: CylinderCandidate) -> None:
        fields = {
            "file_centre_mm": [float(value) for value in other.centre_mm],
            "diameter_mm": other.diameter_mm,
            "width_mm": other.width_mm,
        }
        rows = self._on(other.centre_mm, other.direction, other.diameter_mm, other.width_mm)
        self.add({**part, **fields}, rows)

    def _on(self, centre: Array, axis: Array, diameter: float, width: float) -> Indices:
        """Return the triangles whose corners lie on a cylinder."""
        away = self.corners - centre
        along = away @ axis
        radius = np.linalg.norm(away - along[:, None] * axis, axis=1)
        half = 0.5 * diameter
        near = (np.abs(radius - half) <= ON_CYLINDER * half) & (np.abs(along) <= 0.5 * width + 0.02 * half)
        at = along[self.triangles]
        upright = (
            np.ptp(at, axis=1) > 1e-3 * half
        )  # a disc's triangles lie flat, corners on the radius or not
        return np.flatnonzero(near[self.triangles].all(axis=1) & upright).astype(np.int64)

    def packed(self, head: dict[str, Any]) -> bytes:
        order = along_a_curve(self.corners[self.triangles].mean(axis=1))
        arrays = {
            "corners": self.corners.astype("<f4"),
            "triangles": self.triangles[order].astype("<u4"),
            "part": self.part[order],
            "edges": creases(self.corners, self.triangles),
        }
        return packed({**head, "parts": self.parts}, arrays)


def result_view(result: BalanceResult) -> bytes:
    """Return the crank as it is left and the metal that went, as the report's page shows them."""
    from autobalance.report.page.view import Shown, view_data

    before = result.before.measured.source.solid
    record = result.record.balanced
    assert record is not None
    left, report = record.result.solid or before, result.typed_report
    shown = Shown.of(report, before, record.result.solid, record.result.tools)
    data, meshes = view_data(report, shown.body, shown.pieces)
    head = {
        "view": data,
        "note": shown.note,
        "triangles": len(left.mesh.triangles),
        "anatomy": _coloured(result.before.measured.anatomy),
    }
    edges = creases(shown.body.moved(result.before.file_to_rotor).vertices, shown.body.triangles)
    return packed(head, {"meshes": np.frombuffer(meshes, dtype="u1"), "edges": edges})


def creases(corners: Array, triangles: Indices) -> NDArray[np.float32]:
    """Return the edges that a drawing shows, from corner to corner (k, 6) [mm]."""
    a, b, c = (corners.take(column, axis=0) for column in triangles.T)
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.sqrt(np.einsum("ij,ij->i", normal, normal)), 1e-300)[:, None]
    ends = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    low, high = np.minimum(ends[:, 0], ends[:, 1]), np.maximum(ends[:, 0], ends[:, 1])
    names = low.astype(np.int64) * len(corners) + high
    order = np.argsort(names)
    named = names.take(order)
    same = named[1:] == named[:-1]
    first, second = order[:-1][same], order[1:][same]
    sharp = np.einsum("ij,ij->i", normal.take(first // 3, axis=0), normal.take(second // 3, axis=0))
    edges = named[:-1][same][sharp < CREASE_COSINE]
    ends = np.stack([edges // len(corners), edges % len(corners)], axis=1)
    drawn: NDArray[np.float32] = corners[ends].reshape(-1, 6).astype("<f4")
    return drawn


# A crank, or what a run left of one, to look at in a notebook.


@dataclass(frozen=True)
class Still:
    """A picture that shows itself in a notebook."""

    png: bytes

    def _repr_png_(self) -> bytes:
        return self.png


def view(source: object, crank: Crank) -> Any:
    """Return the app's view of a crank or a result, which turns.

    A still picture of the crank where the extra ``notebook`` is not installed.
    """
    if find_spec("anywidget") is None:
        return Still(crank_picture(crank.source.solid.mesh, crank.anatomy, crank.faces))
    app = import_module(
        f"autobalance.{registry.functions()['app']}"
    ).app  # by its name: the app stands on this room
    return app(source)

"""The crank and the removed metal for pages and pictures."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalance.report.balance import kinds
from autobalance.report.display_units import PAGE_UNITS, length, unbalance
from autobalance.report.metal import Piece, pieces_of
from autobalance.report.records.balanced import BalancedReport, Cut
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh, compacted
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass
from autobalance.wording import number

# Data of the page's 3D view: meshes packed for the script, labels, planes, vectors.


def view_data(report: BalancedReport, body: Mesh, pieces: Sequence[Piece]) -> tuple[dict[str, Any], bytes]:
    """Return the data of the page's script, and its meshes packed as 16-bit vertices and 32-bit triangles."""
    frame = np.asarray(report.frame.file_to_rotor, dtype=np.float64)
    turned = [body.moved(frame)] + [piece.mesh.moved(frame) for piece in pieces]
    points = np.concatenate([mesh.vertices for mesh in turned])
    low = points.min(axis=0)
    step = float((points.max(axis=0) - low).max()) / 65535.0
    pack = _Packer(low, step)
    shape = pack.add(turned[0].vertices, turned[0].triangles)
    depths = [abs(item.depth_mm) for item in report.corrections]
    parts = []
    for piece, mesh in zip(pieces, turned[1:], strict=True):
        item = report.corrections[piece.correction]
        skin = pack.add(mesh.vertices, piece.skin)
        floor = pack.add(mesh.vertices, piece.floor)
        parts.append(
            {
                "number": item.number,
                "shade": _shade(abs(item.depth_mm), depths),
                "skin": skin,
                "floor": floor,
            }
        )
    z = points[:, 2]
    data = {
        "low_mm": [float(v) for v in low],
        "step_mm": step,
        "z_mm": [float(z.min()), float(z.max())],
        "radius_mm": float(np.hypot(points[:, 0], points[:, 1]).max()),
        "eye": list(kinds.eye(report)),
        "body": shape,
        "pieces": parts,
        "corrections": [_label(item, pieces, turned) for item in enumerate(report.corrections)],
        "tolerance_planes": [{"name": p.name, "z_mm": p.z_mm} for p in report.tolerance.planes],
        "correction_planes_mm": _correction_planes(report),
        "vectors": list(_vectors(report)),
        "length": PAGE_UNITS.get().length,
        "mm_per_length": PAGE_UNITS.get().mm_per_length,
    }
    return data, pack.bytes()


def _shade(depth: float, depths: Sequence[float]) -> float:
    low, high = min(depths), max(depths)
    return 1.0 if number(low) == number(high) else (depth - low) / (high - low)


class _Packer:
    """Buffer of packed meshes."""

    def __init__(self, low: Array, step: float) -> None:
        self.low, self.step = low, step
        self.parts: list[bytes] = []
        self.size = 0

    def add(self, vertices: Array, triangles: Indices) -> dict[str, list[int]]:
        used, renumbered = compacted(triangles, len(vertices))
        places = np.rint((vertices[used] - self.low) / max(self.step, 1e-12)).astype("<u2")
        corners = renumbered.astype("<u4")
        return {"vertices": [self._put(places), len(places)], "triangles": [self._put(corners), len(corners)]}

    def _put(self, array: NDArray[Any]) -> int:
        start, data = self.size, array.tobytes()
        data += b"\0" * (-len(data) % 4)
        self.parts.append(data)
        self.size += len(data)
        return start

    def bytes(self) -> bytes:
        return b"".join(self.parts)


def _label(numbered: tuple[int, Cut], pieces: Sequence[Piece], turned: Sequence[Mesh]) -> dict[str, Any]:
    """Return number, words and place of a correction's label: on its old skin, towards the outside."""
    place, item = numbered
    label = np.asarray(item.position_mm, dtype=np.float64)
    for piece, mesh in zip(pieces, turned[1:], strict=True):
        if piece.correction == place and len(piece.skin):
            corners = mesh.vertices[piece.skin]
            weight = np.linalg.norm(
                np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
            )
            label = weight @ corners.mean(axis=1) / weight.sum()
            break
    depth = f"{length(abs(item.depth_mm), 2)} {PAGE_UNITS.get().length}"
    size = f"{item.of_kind.extent} {depth}"
    return {
        "number": item.number,
        "depth_mm": item.depth_mm,
        "depth_text": depth,
        "label_mm": [float(v) for v in label],
        "towards": _towards(item),
        "said": f"Correction {item.number}: {item.of_kind.noun}, {kinds.place(item)}, {size}",
    }


TILT = 0.55
"""Share of a sideways view in the view of a cut, so that depth and place can both be seen."""

FACE = 0.5
"""Share of the frontal view in that of a face; the rest is from outside, past the webs beside it."""


def _towards(item: Cut) -> list[float]:
    """Return the viewing direction of a correction, rotor frame: along its tool, onto its face or rim."""
    x, y, _ = item.position_mm
    radius = math.hypot(x, y)
    out = np.array([x / radius, y / radius, 0.0]) if radius > 0.0 else np.array([1.0, 0.0, 0.0])
    if item.hole is not None:
        out = -np.asarray(item.hole.inward, dtype=np.float64)
    elif item.new_face is not None:
        out = out + FACE * np.asarray(item.new_face.normal, dtype=np.float64)
        return [float(v) for v in out]
    elif item.pocket is not None and item.pocket.face_z_mm is not None:
        out = np.array([0.0, 0.0, math.copysign(1.0, item.pocket.face_z_mm - item.position_mm[2])])
    beside = np.array([0.0, 0.0, 1.0]) if abs(out[2]) < 0.7 else np.array([x, y, 0.0]) / max(radius, 1e-9)
    return [float(v) for v in out + TILT * beside]


def _correction_planes(report: BalancedReport) -> list[float]:
    """Return the z of the mid-planes of the webs that are cut [mm]."""
    cut = {web for item in report.corrections for web in item.all_webs}
    return [0.5 * (web.z_min_mm + web.z_max_mm) for web in report.crank.webs if web.number in cut]


def _vectors(report: BalancedReport) -> Iterable[dict[str, Any]]:
    for k, plane in enumerate(report.tolerance.planes):
        for state, when in ((report.initial, "before"), (report.residual, "after")):
            if report.outcome == "already_within_tolerance" and when == "before":
                continue
            vector = state.planes[k].unbalance_g_mm
            text = f"{unbalance(math.hypot(*vector), 1)} {PAGE_UNITS.get().unbalance} {when}"
            yield {"z_mm": plane.z_mm, "vector": list(vector), "when": when, "text": text}


# The crank and the removed metal for pages and pictures, as fine as a screen shows and no finer.


VIEW_TRIANGLES = 100_000
"""Triangles above which a crank is shown decimated."""
FINEST_VIEW = 4e-5
"""Share of a solid's size up to which edges are merged first: a twentieth of a pixel of a wide screen."""
MERGED_ROUGHNESS_RATIO = 3.0
"""Multiple of a scan's roughness up to which edges are merged first: finer steps merge almost no edges."""
PIECES_TRIANGLES = 50_000
"""The same for all removed metal; the two limits keep the page below 5 MB."""


@dataclass(frozen=True, eq=False)
class Shown:
    """The view of a run, in file coordinates [mm].

    ``body`` is the corrected crank, ``pieces`` the metal of the corrections, ``note`` the words for a view
    with fewer triangles than the crank has.
    """

    body: Mesh
    pieces: Sequence[Piece]
    note: str | None

    @classmethod
    def of(
        cls,
        report: BalancedReport,
        before: Solid,
        after: Solid | None,
        tools: Sequence[Solid],
        most: int = VIEW_TRIANGLES,
    ) -> Shown:
        """Return the view of a crank before and after (None: nothing was cut), and of the tool bodies.

        A crank of more than ``most`` triangles is decimated before it is cut for the view: cutting it once
        more as it is would take longer than balancing it.
        """
        scanned = report.crank.scanned
        roughness_mm = 0.0 if scanned is None else scanned.roughness_mm
        first = max(
            FINEST_VIEW * before.mesh.diagonal_mm,
            MERGED_ROUGHNESS_RATIO * roughness_mm,
        )
        crank = coarse_solid(before, most, first)
        pieces = pieces_of(report, crank, tools)
        left = before if after is None else after
        cut = after if after is not None and crank is before else _cut(report, crank, tools)
        body = coarse_solid(cut, most, first)
        note = None
        if body.triangle_count < left.triangle_count:
            note = (
                f"The view shows {body.triangle_count:,} of {left.triangle_count:,} triangles; "
                "every number is of all of them."
            ).replace(",", "\u202f")
        return cls(body.mesh, coarse_pieces(report, pieces, before.mesh.diagonal_mm), note)


def coarse_solid(solid: Solid, most: int, step: float) -> Solid:
    """Return a solid of at most ``most`` triangles; if it has more, decimated by ``step`` [mm] or more."""
    coarse = solid
    while coarse.triangle_count > most and step < solid.mesh.diagonal_mm:
        coarse = coarse.simplified(step)
        step *= 2.0
    return coarse


def coarse_pieces(
    report: BalancedReport, pieces: Sequence[Piece], size_mm: float, most: int = PIECES_TRIANGLES
) -> Sequence[Piece]:
    """Return the removed metal for the page's view, simplified while it has more than ``most`` triangles."""
    step, coarse = 1e-5 * size_mm, pieces
    while sum(len(piece.mesh.triangles) for piece in coarse) > most and step < 1e-3 * size_mm:
        coarse = [
            piece.simplified(step, report.corrections[piece.correction].of_kind.adds_metal)
            for piece in pieces
        ]
        step *= 4.0
    return coarse


def _cut(report: BalancedReport, crank: Solid, tools: Sequence[Solid]) -> Solid:
    """Return a crank after all corrections, metal added first and then removed."""
    for adds in (True, False):
        chosen = [
            tool
            for tool, item in zip(tools, report.corrections, strict=True)
            if item.of_kind.adds_metal == adds
        ]
        if chosen:
            crank = crank + union(chosen) if adds else crank - union(chosen)
    return crank

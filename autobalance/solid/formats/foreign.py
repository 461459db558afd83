"""COLLADA, 3DXML and XAML through trimesh's readers: exports of modellers and viewers.

What trimesh passes over with a warning would be metal that is missing, so a warning is a refusal here. The
corrected solid is written as 3MF.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np

from autobalance.errors import FormatError, file_errors
from autobalance.solid.formats.format import Format, spread, step_of_text
from autobalance.solid.formats.raw import Raw
from autobalance.solid.formats.threemf import ARCHIVE_ERRORS, THREEMF, UNITS, UNPACKED_FREE, UNPACKED_MOST
from autobalance.types import Array, Floats

INSTALL: Final = "pip install 'autobalance[meshes]'"
ZIP: Final = b"PK"
MM: Final = "millimeter"
ENTITIES = re.compile(rb"<!(?:ENTITY|DOCTYPE)", re.IGNORECASE)
"""Declarations that let a small text grow without end, or name other files."""
UNIT, HEAD = re.compile(rb"<(?:\w+:)?unit\b"), 1 << 16
"""Statement of COLLADA's unit, and the bytes in which it is sought."""
MESH_PART = re.compile(rb'<(?:\w+:)?ReferenceRep\b[^>]*\bformat\s*=\s*"TESSELLATED"')
POSITIONS_3DXML = re.compile(rb"<(?:\w+:)?Positions>([^<]*)<")
POSITIONS_XAML = re.compile(rb'\bPositions="([^"]*)"')


def _read_dae(data: bytes) -> Raw:
    """Return the triangles of a COLLADA file in its own unit, else in mm where 3MF has no such unit."""
    if _is_3mf(data):
        return THREEMF.read(data)
    _refuse_entities("COLLADA", [data])
    words, metres = _of_collada(data)
    # COLLADA's numbers pass through single precision in trimesh's reader
    soup, step = _soup("COLLADA", "dae", data, words, np.float32, strict={"ignore_broken": False})
    if metres is None:
        return Raw(soup, step=step)
    mm = 1000.0 * metres
    unit = next((name for name, size in UNITS.items() if np.isclose(size, mm, rtol=1e-9)), None)
    if unit is None:
        return Raw(soup * mm, MM, 1.0, step=step * mm)
    return Raw(soup, unit, UNITS[unit], step=step)


def _of_collada(data: bytes) -> tuple[list[bytes], float | None]:
    """Return the coordinates as written, and the unit [m] if it is stated.

    COLLADA's default is the metre, but programs that state no unit write millimetres as often.
    """
    from xml.etree import ElementTree

    try:
        root = ElementTree.fromstring(data)
        lists = {}
        for source in root.iterfind(".//{*}source[@id]"):
            numbers = source.find("{*}float_array")
            if numbers is not None:
                lists[source.get("id")] = (numbers.text or "").encode().split()
        named = {
            str(each.get("source"))[1:]
            for each in root.iterfind(".//{*}vertices/{*}input")
            if each.get("semantic") == "POSITION"
        }
        unit = root.find("{*}asset/{*}unit")
        metres = None if unit is None else float(unit.get("meter", "1"))
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise FormatError(f"the COLLADA file is not XML as COLLADA needs: {str(error)[:80]}") from None
    if metres is not None and not 0.0 < metres < np.inf:
        raise FormatError(f"the COLLADA file states a unit of {metres:g} m; expected a length above 0")
    return [word for name in sorted(named & lists.keys()) for word in lists[name]], metres


def _states_no_unit(path: Path) -> bool:
    """Return whether a COLLADA file leaves its unit open."""
    with file_errors(f"read {path}"), path.open("rb") as stream:
        head = stream.read(HEAD)
    return not head.startswith(ZIP) and UNIT.search(head) is None


def _read_3dxml(data: bytes) -> Raw:
    """Return the triangles of a 3DXML archive [mm]."""
    if _is_3mf(data):
        return THREEMF.read(data)
    parts = _unpacked(data)
    _refuse_entities("3DXML", parts)
    words = [word for part in parts for text in POSITIONS_3DXML.findall(part) for word in _words(text)]
    meshes = sum(len(MESH_PART.findall(part)) for part in parts)
    soup, step = _soup("3DXML", "3dxml", data, words, np.float64, meshes)
    return Raw(soup, MM, 1.0, step=step)


def _unpacked(data: bytes) -> list[bytes]:
    """Return the parts of an archive, up to a total size."""
    limit = max(UNPACKED_MOST * len(data), UNPACKED_FREE)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            parts = []
            for member in archive.infolist():
                with archive.open(member) as stream:
                    parts.append(stream.read(limit + 1))
                limit -= len(parts[-1])
                if limit < 0:
                    raise FormatError(f"the 3DXML file unpacks to more than {UNPACKED_MOST} times its bytes")
    except ARCHIVE_ERRORS as error:
        raise FormatError(f"the 3DXML file is not a zip archive: {str(error)[:80]}") from None
    return parts


def _read_xaml(data: bytes) -> Raw:
    """Return the triangles of a XAML file, in a unit that it does not state."""
    if _is_3mf(data):
        return Raw(THREEMF.read(data).soup)
    _refuse_entities("XAML", [data])
    words = [word for text in POSITIONS_XAML.findall(data) for word in _words(text)]
    soup, step = _soup("XAML", "xaml", data, words, np.float64)
    return Raw(soup, step=step)


def _words(text: bytes) -> list[bytes]:
    return text.replace(b",", b" ").split()


def _is_3mf(data: bytes) -> bool:
    """Return whether bytes are a corrected solid as this program writes it."""
    return data.startswith(ZIP) and b"3D/3dmodel.model" in data


def _refuse_entities(what: str, texts: Sequence[bytes]) -> None:
    if any(ENTITIES.search(text) for text in texts):
        raise FormatError(f"the {what} file declares XML entities; expected plain XML")


def _soup(
    what: str, ending: str, data: bytes, words: Sequence[bytes], number: type[np.floating[Any]],
    meshes: int = 0, strict: dict[str, Any] | None = None,
) -> tuple[Floats, float]:  # fmt: skip
    """Return all triangles that a file places, and the step between its coordinates at the far end.

    Parameters
    ----------
    what, ending : str
        Name of the format for messages, and trimesh's name of it.
    data : bytes
    words : sequence of bytes
        Coordinates as written.
    number : type
        Precision of trimesh's reader.
    meshes : int
        Number of meshes that the file lists, where that is known.
    strict : dict, optional
        Options of trimesh's reader.

    Raises
    ------
    FormatError
        If the reader is missing, fails, warns, or passes over a mesh.
    """
    _refuse_odd_numbers(what, words)
    scene = _scene(what, ending, data, strict or {})
    if len(scene.geometry) < meshes:
        raise FormatError(
            f"the {what} file lists {meshes} meshes, but only {len(scene.geometry)} were read: some share "
            "a name; export STEP or STL"
        )
    pieces, scales = [np.zeros((0, 3, 3))], [0.0]
    for node in scene.graph.nodes_geometry:
        placement, name = scene.graph[node]
        mesh = scene.geometry[name]
        corners = np.asarray(mesh.vertices, dtype=np.float64)[np.asarray(mesh.faces)]
        turn: Array = np.asarray(placement, dtype=np.float64)
        if np.linalg.det(turn[:3, :3]) < 0.0:  # a mirrored copy would be inside out
            corners = corners[:, ::-1]
        pieces.append(corners @ turn[:3, :3].T + turn[:3, 3])
        scales.append(float(np.linalg.norm(turn[:3, :3], 2)))
    soup = np.concatenate(pieces)
    if not len(soup):
        raise FormatError(f"the {what} file holds no triangles; expected at least one")
    rounding = float(np.spacing(number(np.abs(soup).max())))
    return soup, max(max(scales) * step_of_text(spread(words)), rounding)


def _refuse_odd_numbers(what: str, words: Sequence[bytes]) -> None:
    """Refuse coordinates that are not finite numbers: a reader makes 0 of them in silence."""
    try:
        numbers = np.array(words, dtype=np.bytes_).astype(np.float64)
    except ValueError as error:
        raise FormatError(
            f"the {what} file has a coordinate that is not a number: {str(error)[:60]}"
        ) from None
    if not np.isfinite(numbers).all():
        raise FormatError(f"the {what} file has a face with a corner that is not finite")


def _scene(what: str, ending: str, data: bytes, strict: dict[str, Any]) -> Any:
    import trimesh

    if ending not in trimesh.available_formats():
        raise FormatError(f"a {what} file needs readers that are not installed: {INSTALL}; or export STL")
    try:
        with _warnings() as warned:
            scene = trimesh.load(io.BytesIO(data), file_type=ending, force="scene", process=False, **strict)
    except Exception as error:  # noqa: BLE001 -- its readers raise whatever a wrong file made of them
        found = f"{type(error).__name__}: {str(error)[:120]}"
        raise FormatError(f"the {what} file cannot be read ({found}); export STEP or STL") from None
    if warned:
        raise FormatError(f"the {what} file cannot be read whole: {warned[0][:160]}; export STEP or STL")
    return scene


@contextmanager
def _warnings() -> Iterator[list[str]]:
    """Collect what trimesh warns of."""
    import logging

    found: list[str] = []

    class Collect(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            found.append(record.getMessage())

    log, handler = logging.getLogger("trimesh"), Collect(logging.WARNING)
    log.addHandler(handler)
    passes_on, log.propagate = log.propagate, False
    try:
        yield found
    finally:
        log.propagate = passes_on
        log.removeHandler(handler)


DAE = Format("dae", _read_dae, THREEMF.write, np.float64, carries_unit=True, states_no_unit=_states_no_unit)
THREEDXML = Format("3dxml", _read_3dxml, THREEMF.write, np.float64, carries_unit=True)
XAML = Format("xaml", _read_xaml, THREEMF.write, np.float64)

"""3MF, core specification: a zip archive with a model in XML. Read with limits, no entities, no recursion."""

from __future__ import annotations

import io
import zipfile
import zlib
from array import array
from dataclasses import dataclass, field
from typing import Final
from xml.parsers import expat

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.formats.format import Format
from autobalance.solid.formats.raw import Raw, soup_of
from autobalance.solid.mesh.mesh import Array, Indices

UNITS: Final = {
    "micron": 0.001,
    "millimeter": 1.0,
    "centimeter": 10.0,
    "inch": 25.4,
    "foot": 304.8,
    "meter": 1000.0,
}
"""Millimetres in one unit of a model."""
UNPACKED_MOST: Final = 100
"""How many times its own size an archive may unpack to; models are about ten times smaller packed."""
UNPACKED_FREE: Final = 1 << 24
"""Bytes that any archive may unpack to."""
DEPTH_MOST: Final = 32
"""Levels of components within components."""
XML_DEPTH_MOST: Final = 64
"""Levels of elements within elements; the parser keeps something for each that is open."""
PIECE: Final = 1 << 16
"""Bytes of the model that are unpacked at a time."""
PACKINGS: Final = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""How 3MF may pack; others name the size of their memory in the file."""
CORE: Final = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
PACKAGE: Final = "http://schemas.openxmlformats.org/package/2006"
CONTENT_TYPES: Final = (
    f'<Types xmlns="{PACKAGE}/content-types"><Default Extension="rels"'
    ' ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model"'
    ' ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
RELATIONSHIPS: Final = (
    f'<Relationships xmlns="{PACKAGE}/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0"'
    ' Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)


@dataclass(eq=False)
class _Object:
    vertices: array[float] = field(default_factory=lambda: array("d"))
    triangles: array[int] = field(default_factory=lambda: array("q"))
    components: list[tuple[str, Array]] = field(default_factory=list)


class _Model:
    """Collects what the XML parser meets."""

    def __init__(self) -> None:
        self.unit = "millimeter"
        self.objects: dict[str, _Object] = {}
        self.items: list[tuple[str, Array]] = []
        self.current = _Object()
        self.depth = 0

    def end(self, _: str) -> None:
        self.depth -= 1

    def start(self, tag: str, value: dict[str, str]) -> None:
        self.depth += 1
        if self.depth > XML_DEPTH_MOST:
            raise FormatError(f"the model in the 3MF file nests XML more than {XML_DEPTH_MOST} deep")
        match tag.rpartition("|")[2]:
            case "vertex":
                self.current.vertices.extend((float(value["x"]), float(value["y"]), float(value["z"])))
            case "triangle":
                self.current.triangles.extend((int(value["v1"]), int(value["v2"]), int(value["v3"])))
            case "object":
                self.current = _Object()
                self.objects[value["id"]] = self.current
            case "component":
                self.current.components.append((value["objectid"], _placement(value.get("transform"))))
            case "item":
                self.items.append((value["objectid"], _placement(value.get("transform"))))
            case "model":
                self.unit = value.get("unit", "millimeter")


def read_3mf(data: bytes) -> Raw:
    """Read every object that a 3MF file builds, in place, in the model's unit.

    Raises
    ------
    FormatError
        If the archive or the model is damaged, claims to be far larger than it is, uses XML entities, or
        its components contain each other.
    """
    model, size = _model(data)
    if model.unit not in UNITS:
        raise FormatError(f"the 3MF file is in '{model.unit[:20]}'; needed one of {', '.join(UNITS)}")
    budget = size  # triangles that components may multiply to; one of the model's own takes 30 bytes
    parts: list[tuple[Array, Indices]] = []
    placed = model.items or [(name, np.eye(4)[:3]) for name in model.objects]
    for name, placement in placed:
        budget = _collect(model, name, placement, DEPTH_MOST, budget, parts)
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    if not parts:
        raise FormatError("the 3MF file holds no triangles; needed at least one")
    vertices = np.concatenate([vertices for vertices, _ in parts])
    for points, triangles in parts:
        soup_of(points, triangles, "3MF")
    numbers = np.concatenate([t + shift for (_, t), shift in zip(parts, offsets[:-1], strict=True)])
    soup = soup_of(vertices, numbers, "3MF")
    return Raw(soup, model.unit, UNITS[model.unit], len(vertices))


def _collect(
    model: _Model, name: str, placement: Array, depth: int, budget: int, parts: list[tuple[Array, Indices]]
) -> int:
    """Append an object and its components in place; return how many triangles may still come."""
    if depth == 0:
        raise FormatError(f"the 3MF file nests components more than {DEPTH_MOST} deep, or in a circle")
    if name not in model.objects:
        raise FormatError(f"the 3MF file uses the object '{name[:20]}', which it does not hold")
    one = model.objects[name]
    budget -= 1 + len(one.triangles) // 3
    if budget < 0:
        raise FormatError("the 3MF file multiplies its components beyond reason")
    if one.triangles:
        points = np.frombuffer(one.vertices, dtype=np.float64).reshape(-1, 3)
        triangles = np.frombuffer(one.triangles, dtype=np.int64).reshape(-1, 3)
        if np.linalg.det(placement[:, :3]) < 0.0:  # a mirrored copy would be inside out
            triangles = triangles[:, ::-1]
        parts.append((points @ placement[:, :3].T + placement[:, 3], triangles))
    for child, local in one.components:
        turn = placement[:, :3] @ local[:, :3]
        shift = placement[:, :3] @ local[:, 3] + placement[:, 3]
        budget = _collect(model, child, np.column_stack([turn, shift]), depth - 1, budget, parts)
    return budget


def _placement(text: str | None) -> Array:
    """Return the matrix (3, 4) of an attribute of twelve numbers, which lists it by columns."""
    if text is None:
        return np.eye(4)[:3]
    numbers = np.array([float(word) for word in text.split()])
    if numbers.shape != (12,):
        raise ValueError(f"a transform of {len(numbers)} numbers")
    return numbers.reshape(4, 3).T


def _model(data: bytes) -> tuple[_Model, int]:
    """Unpack and parse the model piece by piece, up to the limit, whatever size it claims."""
    limit = UNPACKED_FREE + UNPACKED_MOST * len(data)
    model, size = _Model(), 0
    parser = _parser(model)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive, archive.open(_member(archive)) as stream:
            while piece := stream.read(PIECE):
                size += len(piece)
                if size > limit:
                    raise FormatError(
                        f"the 3MF file unpacks to more than {UNPACKED_MOST} times its {len(data)} bytes"
                    )
                _parse(parser, piece)
            _parse(parser, b"", last=True)
    except FormatError:
        raise
    except (
        zipfile.BadZipFile,
        zlib.error,
        EOFError,
        OSError,
        RuntimeError,
        NotImplementedError,
        ValueError,
    ) as error:
        raise FormatError(
            f"the 3MF file is no readable zip archive: {' '.join(str(error).split())[:80]}"
        ) from None
    return model, size


def _member(archive: zipfile.ZipFile) -> zipfile.ZipInfo:
    """Return the model's place in the archive; nothing is ever unpacked under its name."""
    members = [one for one in archive.infolist() if one.filename.lower().endswith(".model")]
    members.sort(key=lambda one: (one.filename.lower().lstrip("/") != "3d/3dmodel.model", one.filename))
    if not members:
        raise FormatError("the 3MF file holds no model; needed 3D/3dmodel.model in the archive")
    if members[0].compress_type not in PACKINGS:
        method = members[0].compress_type
        raise FormatError(
            f"the 3MF file packs its model by method {method}; needed 0 (stored) or 8 (deflated)"
        )
    return members[0]


def _parser(model: _Model) -> expat.XMLParserType:
    parser = expat.ParserCreate(namespace_separator="|")

    def refuse(*_: object) -> None:
        raise FormatError("the model in the 3MF file declares XML entities; needed plain XML")

    parser.StartElementHandler = model.start
    parser.EndElementHandler = model.end
    parser.EntityDeclHandler = refuse
    parser.StartDoctypeDeclHandler = refuse
    return parser


def _parse(parser: expat.XMLParserType, piece: bytes, last: bool = False) -> None:
    try:
        parser.Parse(piece, last)
    except expat.ExpatError as error:
        raise FormatError(f"the model in the 3MF file is no XML: {error}") from None
    except KeyError as error:
        raise FormatError(f"the model in the 3MF file lacks the attribute {error}") from None
    except LookupError as error:  # an encoding that Python does not know
        raise FormatError(f"the model in the 3MF file is no XML: {str(error)[:80]}") from None
    except FormatError:
        raise
    except (ValueError, OverflowError) as error:
        raise FormatError(f"the model in the 3MF file has a wrong number: {str(error)[:80]}") from None


def write_3mf(vertices: Array, triangles: Indices, unit: str) -> bytes:
    """Return a 3MF file with every digit of the coordinates; the same bytes for the same mesh."""
    rows = (f'<vertex x="{x!r}" y="{y!r}" z="{z!r}"/>' for x, y, z in vertices.tolist())
    faces = (f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles.tolist())
    head = '<?xml version="1.0" encoding="UTF-8"?>\n'
    model = (
        f'{head}<model unit="{unit}" xml:lang="en-US" xmlns="{CORE}"><resources>'
        f'<object id="1" type="model"><mesh><vertices>{"".join(rows)}</vertices>'
        f"<triangles>{''.join(faces)}</triangles></mesh></object></resources>"
        '<build><item objectid="1"/></build></model>\n'
    )
    files = {"[Content_Types].xml": head + CONTENT_TYPES, "_rels/.rels": head + RELATIONSHIPS}
    files["3D/3dmodel.model"] = model
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), text, zipfile.ZIP_DEFLATED, 6)
    return buffer.getvalue()


def _write(vertices: Array, triangles: Indices, mm_per_unit: float) -> bytes:
    unit = next((name for name, mm in UNITS.items() if mm == mm_per_unit), None)
    if unit is None:
        raise FormatError(f"3MF has no unit of {mm_per_unit:g} mm; needed one of {', '.join(UNITS)}")
    return write_3mf(vertices, triangles, unit)


THREEMF = Format("3mf", ("3mf",), read_3mf, _write, np.float64, carries_unit=True)

"""3MF files: named meshes in one model, packed with the parts that a reader expects."""

from __future__ import annotations

import io
import zipfile
import zlib
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import field
from typing import Final
from xml.parsers import expat

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.formats.format import SAMPLE, Format, step_of_text
from autobalance.solid.formats.raw import Raw, soup_of
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Writing of 3MF files: named meshes in one model, packed with the parts that a reader expects.


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


def write_3mf(vertices: Array, triangles: Indices, unit: str) -> bytes:
    """Return a 3MF file with every digit of the coordinates; the same bytes for the same mesh."""
    return write_objects([("", vertices, triangles)], unit)


def write_objects(objects: Sequence[tuple[str, Array, Indices]], unit: str) -> bytes:
    """Return a 3MF file of meshes with their names, side by side; an empty name is left out."""
    written = "".join(_object(number, *each) for number, each in enumerate(objects, 1))
    items = "".join(f'<item objectid="{number + 1}"/>' for number in range(len(objects)))
    head = '<?xml version="1.0" encoding="UTF-8"?>\n'
    model = (
        f'{head}<model unit="{unit}" xml:lang="en-US" xmlns="{CORE}"><resources>{written}</resources>'
        f"<build>{items}</build></model>\n"
    )
    files = {"[Content_Types].xml": head + CONTENT_TYPES, "_rels/.rels": head + RELATIONSHIPS}
    files["3D/3dmodel.model"] = model
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), text, zipfile.ZIP_DEFLATED, 6)
    return buffer.getvalue()


def _object(number: int, name: str, vertices: Array, triangles: Indices) -> str:
    from xml.sax.saxutils import quoteattr  # loads all of urllib

    rows = (f'<vertex x="{x!r}" y="{y!r}" z="{z!r}"/>' for x, y, z in vertices.tolist())
    faces = (f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles.tolist())
    named = f" name={quoteattr(name)}" if name else ""
    return (
        f'<object id="{number}" type="model"{named}><mesh><vertices>{"".join(rows)}</vertices>'
        f"<triangles>{''.join(faces)}</triangles></mesh></object>"
    )


# 3MF, core and production specification: a zip archive with models in XML.
#
# Read with limits, without entities.


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
"""Size an archive may unpack to, as a multiple of its size; packed models are about ten times smaller."""
UNPACKED_FREE: Final = 1 << 24
"""Bytes that any archive may unpack to."""
DEPTH_MOST: Final = 32
"""Levels of components within components."""
XML_DEPTH_MOST: Final = 64
"""Levels of elements within elements; the parser keeps memory for each open one."""
PIECE: Final = 1 << 16
"""Bytes of the model that are unpacked at a time."""
PACKINGS: Final = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""Methods of packing in 3MF; others let the file set the size of their memory."""
ARCHIVE_ERRORS: Final = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    OSError,
    RuntimeError,
    NotImplementedError,
    ValueError,
)
"""Errors that reading a damaged archive may raise."""
RELS: Final = "_rels/.rels"
USUAL_ROOT: Final = "3d/3dmodel.model"
NAMESPACES: Final = "http://schemas.microsoft.com/3dmanufacturing/"
CORES: Final = (f"{NAMESPACES}core/", f"{NAMESPACES}2013/")
"""Beginnings of the namespaces of the core specification."""
PRODUCTION: Final = f"{NAMESPACES}production/"
EXTENSIONS: Final = (*CORES, PRODUCTION, f"{NAMESPACES}material/", f"{NAMESPACES}trianglesets/")
"""Beginnings of the namespaces of extensions that leave the shape to the core, or are read."""


SUPPORTS: Final = ("support", "solidsupport")


@dataclass(frozen=True, eq=False)
class _Use:
    """Use of an object: its part of the archive, its name there, and its placement (3, 4)."""

    part: str
    name: str
    placement: Array


@dataclass(eq=False)
class _Object:
    """A mesh, or components; ``support`` only holds a part up while it is printed, and is none of it."""

    support: bool = False
    vertices: array[float] = field(default_factory=lambda: array("d"))
    triangles: array[int] = field(default_factory=lambda: array("q"))
    components: list[_Use] = field(default_factory=list)


class _Model:
    """Collector of the objects and items that the XML parser meets in one part of the archive."""

    def __init__(self, part: str) -> None:
        self.part = part
        self.unit = "millimeter"
        self.objects: dict[str, _Object] = {}
        self.items: list[_Use] = []
        self.written: list[bytes] = []
        """Coordinates as they are written, of every ``every``-th vertex."""
        self.every = 1
        self._current = _Object()
        self._depth = self._vertices = 0
        self._spaces: dict[str, str] = {}

    def namespace(self, prefix: str | None, uri: str | None) -> None:
        self._spaces[prefix or ""] = uri or ""

    def end(self, _: str) -> None:
        self._depth -= 1

    def start(self, tag: str, value: dict[str, str]) -> None:
        self._depth += 1
        if self._depth > XML_DEPTH_MOST:
            raise FormatError(f"the model in the 3MF file nests XML more than {XML_DEPTH_MOST} deep")
        space, _, name = tag.rpartition("|")
        if space and not space.startswith(CORES):  # an extension's own; what cannot be left out is required
            return
        match name:
            case "vertex":
                self._vertex(value["x"], value["y"], value["z"])
            case "triangle":
                self._current.triangles.extend((int(value["v1"]), int(value["v2"]), int(value["v3"])))
            case "object":
                self._current = _Object(value.get("type") in SUPPORTS)
                self.objects[value["id"]] = self._current
            case "component":
                self._current.components.append(self._use(value))
            case "item":
                self.items.append(self._use(value))
            case "model":
                self.unit = value.get("unit", "millimeter")
                self._check_extensions(value.get("requiredextensions", "").split())

    def _vertex(self, x: str, y: str, z: str) -> None:
        self._current.vertices.extend((float(x), float(y), float(z)))
        if self._vertices % self.every == 0:
            self.written += [x.encode(), y.encode(), z.encode()]
            if len(self.written) > 6 * SAMPLE:
                self.written = [
                    word for k in range(0, len(self.written), 6) for word in self.written[k : k + 3]
                ]
                self.every *= 2
        self._vertices += 1

    def _use(self, value: dict[str, str]) -> _Use:
        path = next((value[key] for key in value if key.startswith(PRODUCTION) and key.endswith("|path")), "")
        return _Use(_in_archive(path) or self.part, value["objectid"], _placement(value.get("transform")))

    def _check_extensions(self, prefixes: list[str]) -> None:
        for prefix in prefixes:
            space = self._spaces.get(prefix, prefix)
            if not space.startswith(EXTENSIONS):
                raise FormatError(
                    f"the 3MF file requires the extension '{space[:80]}', which is not read; "
                    "expected plain triangles"
                )


def read_3mf(data: bytes) -> Raw:
    """Read every object that a 3MF file builds, in place, in the model's unit.

    Raises
    ------
    FormatError
        If the archive or a model in it is damaged, requires an extension that is not read, claims to be far
        larger than it is, uses XML entities, or its components contain each other.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return _built(_Archive(archive, UNPACKED_FREE + UNPACKED_MOST * len(data)))
    except FormatError:
        raise
    except ARCHIVE_ERRORS as error:
        raise FormatError(
            f"the 3MF file is not a readable zip archive: {' '.join(str(error).split())[:80]}"
        ) from None


def _built(archive: _Archive) -> Raw:
    """Return the triangles of all items of the root model, or of all its objects if it lists none."""
    root = archive.model(_root(archive))
    if root.unit not in UNITS:
        raise FormatError(f"the 3MF file is in '{root.unit[:20]}'; expected one of {', '.join(UNITS)}")
    collected = _Collected(archive, root.unit)
    for use in root.items or [_Use(root.part, name, np.eye(4)[:3]) for name in root.objects]:
        collected.add(use, DEPTH_MOST)
    parts = collected.parts
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    if not parts:
        raise FormatError("the 3MF file holds no triangles; expected at least one")
    vertices = np.concatenate([vertices for vertices, _ in parts])
    for points, triangles in parts:
        soup_of(points, triangles, "3MF")
    numbers = np.concatenate([t + shift for (_, t), shift in zip(parts, offsets[:-1], strict=True)])
    soup = soup_of(vertices, numbers, "3MF")
    step = step_of_text(word for model in archive.models.values() for word in model.written)
    return Raw(soup, root.unit, UNITS[root.unit], len(vertices), step)


class _Collected:
    """The objects that a model builds, each in its place."""

    def __init__(self, archive: _Archive, unit: str) -> None:
        self.parts: list[tuple[Array, Indices]] = []
        self._archive, self._unit = archive, unit
        self._taken = 0

    def add(self, use: _Use, depth: int) -> None:
        """Append an object and its components in place."""
        if depth == 0:
            raise FormatError(f"the 3MF file nests components more than {DEPTH_MOST} deep, or in a circle")
        model = self._archive.model(use.part)
        if model.unit != self._unit:
            raise FormatError(
                f"the 3MF file's '{use.part[:40]}' is in {model.unit[:20]}, its root model in {self._unit}; "
                "expected one unit"
            )
        if use.name not in model.objects:
            raise FormatError(f"the 3MF file uses the object '{use.name[:20]}', which it does not hold")
        one, placement = model.objects[use.name], use.placement
        if one.support:
            return
        self._taken += 1 + len(one.triangles) // 3
        if self._taken > self._archive.unpacked:  # one of a model's own triangles takes 30 bytes
            raise FormatError("the 3MF file multiplies its components beyond reason")
        if one.triangles:
            points = np.frombuffer(one.vertices, dtype=np.float64).reshape(-1, 3)
            triangles = np.frombuffer(one.triangles, dtype=np.int64).reshape(-1, 3)
            if np.linalg.det(placement[:, :3]) < 0.0:  # a mirrored copy would be inside out
                triangles = triangles[:, ::-1]
            self.parts.append((points @ placement[:, :3].T + placement[:, 3], triangles))
        for child in one.components:
            turn = placement[:, :3] @ child.placement[:, :3]
            shift = placement[:, :3] @ child.placement[:, 3] + placement[:, 3]
            self.add(_Use(child.part, child.name, np.column_stack([turn, shift])), depth - 1)


def _placement(text: str | None) -> Array:
    """Return the matrix (3, 4) of an attribute of twelve numbers, which lists it by columns."""
    if text is None:
        return np.eye(4)[:3]
    numbers = np.array([float(word) for word in text.split()])
    if numbers.shape != (12,):
        raise ValueError(f"a transform of {len(numbers)} numbers")
    return numbers.reshape(4, 3).T


class _Archive:
    """Archive whose parts are unpacked and parsed in pieces, up to a total limit, not trusting stated sizes.

    Nothing is ever unpacked under its name.
    """

    def __init__(self, archive: zipfile.ZipFile, limit: int) -> None:
        self.models: dict[str, _Model] = {}
        self.unpacked = 0
        self._archive, self._limit = archive, limit
        self._members = {_in_archive(one.filename): one for one in archive.infolist()}

    @property
    def names(self) -> list[str]:
        return list(self._members)

    def model(self, part: str) -> _Model:
        if part not in self.models:
            model = _Model(part)
            parser = _guarded_parser()
            parser.StartElementHandler = model.start
            parser.EndElementHandler = model.end
            parser.StartNamespaceDeclHandler = model.namespace
            for piece in self.pieces(part):
                _parse(parser, piece)
            _parse(parser, b"", last=True)
            self.models[part] = model
        return self.models[part]

    def pieces(self, part: str) -> Iterator[bytes]:
        if part not in self._members:
            raise FormatError(f"the 3MF file refers to '{part[:60]}', which its archive does not hold")
        member = self._members[part]
        if member.compress_type not in PACKINGS:
            raise FormatError(
                f"the 3MF file packs its model by method {member.compress_type}; "
                "expected 0 (stored) or 8 (deflated)"
            )
        with self._archive.open(member) as stream:
            while piece := stream.read(PIECE):
                self.unpacked += len(piece)
                if self.unpacked > self._limit:
                    raise FormatError(f"the 3MF file unpacks to more than {UNPACKED_MOST} times its bytes")
                yield piece


def _in_archive(name: str) -> str:
    """Return a part's name for comparison: without regard to case, from the archive's root."""
    return name.replace("\\", "/").lstrip("/").casefold()


def _root(archive: _Archive) -> str:
    """Return the name of the root model: by the archive's relationships, else at its usual place."""
    if RELS in archive.names:
        targets = _model_targets(archive)
        if targets:
            return _in_archive(targets[0])
    models = sorted(name for name in archive.names if name.endswith(".model"))
    if not models:
        raise FormatError("the 3MF file holds no model; expected 3D/3dmodel.model in the archive")
    return USUAL_ROOT if USUAL_ROOT in models else models[0]


def _model_targets(archive: _Archive) -> list[str]:
    """Return the names of the parts that the archive's relationships call its model."""
    targets: list[str] = []

    def start(tag: str, value: dict[str, str]) -> None:
        if tag.rpartition("|")[2] == "Relationship" and value.get("Type", "").endswith("/3dmodel"):
            targets.append(value.get("Target", ""))

    parser = _guarded_parser()
    parser.StartElementHandler = start
    for piece in archive.pieces(RELS):
        _parse(parser, piece)
    _parse(parser, b"", last=True)
    return targets


def _guarded_parser() -> expat.XMLParserType:
    parser = expat.ParserCreate(namespace_separator="|")

    def refuse(*_: object) -> None:
        raise FormatError("the model in the 3MF file declares XML entities; expected plain XML")

    parser.EntityDeclHandler = refuse
    parser.StartDoctypeDeclHandler = refuse
    return parser


def _parse(parser: expat.XMLParserType, piece: bytes, last: bool = False) -> None:
    try:
        parser.Parse(piece, last)
    except expat.ExpatError as error:
        raise FormatError(f"the model in the 3MF file is not XML: {error}") from None
    except KeyError as error:
        raise FormatError(f"the model in the 3MF file lacks the attribute {error}") from None
    except LookupError as error:  # an encoding that Python does not know
        raise FormatError(f"the model in the 3MF file is not XML: {str(error)[:80]}") from None
    except FormatError:
        raise
    except (ValueError, OverflowError) as error:
        raise FormatError(f"the model in the 3MF file has a wrong number: {str(error)[:80]}") from None


def _write(vertices: Array, triangles: Indices, mm_per_unit: float) -> bytes:
    unit = next((name for name, mm in UNITS.items() if mm == mm_per_unit), None)
    if unit is None:
        raise FormatError(f"3MF has no unit of {mm_per_unit:g} mm; expected one of {', '.join(UNITS)}")
    return write_3mf(vertices, triangles, unit)


THREEMF = Format("3mf", read_3mf, _write, np.float64, carries_unit=True)

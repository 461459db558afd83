"""Writing of 3MF files: named meshes in one model, packed with the parts that a reader expects."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Sequence
from typing import Final

from autobalance.types import Array, Indices

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

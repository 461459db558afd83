"""The files that were written."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from autobalance.declare import (
    ABSENT,
    INLINE,
    Absent,
    Like,
    Ordinal,
    Sha256,
    record,
)
from autobalance.declare.schema import open_keys
from autobalance.report.records.crank import MassProperties

if TYPE_CHECKING:
    pass


@record
class Solid:
    """A written solid and what is claimed of it, rotor frame."""

    file: str
    sha256: Annotated[str | None, Like(Sha256)]
    triangles: Annotated[Ordinal | None, "null where the file keeps true surfaces"]
    body: Annotated[MassProperties, INLINE]


@record
class Page:
    """A written file for people."""

    file: str
    sha256: Sha256


@open_keys
@record
class Outputs:
    """Written files by kind."""

    solid: Solid | Absent | None = ABSENT
    solid_holds_slugs: Annotated[bool, "false: there are slugs, and the solid lacks them"] | Absent = ABSENT
    html: Page | Absent = ABSENT
    pdf: Page | Absent = ABSENT
    xlsx: Page | Absent = ABSENT
    png_before: Page | Absent = ABSENT
    png_after: Page | Absent = ABSENT
    dxf: Page | Absent = ABSENT
    tools: Page | Absent = ABSENT
    certificate: Page | Absent = ABSENT
    card: Page | Absent = ABSENT
    csv: Page | Absent = ABSENT
    history: Annotated[Page, "of all stages: recut"] | Absent = ABSENT

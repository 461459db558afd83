"""What a report says of keyways, flanges and faces that can be touched."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, Self

from autobalance.records import (
    Angle,
    Positive,
    record,
)

if TYPE_CHECKING:
    from autobalance.crank import datums as crank_datums


@record
class Keyway:
    """A slot along a shaft at an end of the crank; depth from the shaft's surface above it."""

    end: Literal["-z", "+z"]
    angle_deg: Angle
    width_mm: Positive
    depth_mm: Positive
    shaft_diameter_mm: Positive
    z_min_mm: float
    z_max_mm: float


@record
class FlangeHole:
    """A hole of a bolt circle."""

    angle_deg: Angle
    radius_mm: Positive
    diameter_mm: Positive


@record
class Flange:
    """A disc at an end of the crank, its outer face (null: not plane) and its bolt circle."""

    end: Literal["-z", "+z"]
    diameter_mm: Positive
    face_z_mm: float | None
    holes: Sequence[FlangeHole]


@record
class DatumAngle:
    """What angles are measured from besides crankpin 1, and where it stands."""

    of: Literal["keyway", "flange_hole"]
    angle_deg: Angle


@record
class DatumFace:
    """A plane face square to the axis, from which z is measured."""

    of: Literal["flange", "web", "end"]
    name: str
    z_mm: float


@record
class Datums:
    """What can be touched to set the crank up, faces the best first; null or empty where there is none."""

    keyways: Sequence[Keyway]
    flanges: Sequence[Flange]
    angle: DatumAngle | None
    faces: Sequence[DatumFace]

    @classmethod
    def of(cls, datums: crank_datums.Datums) -> Self:
        """Return those of a crank."""
        angle = datums.angle
        return cls(
            keyways=[Keyway(**vars(each)) for each in datums.keyways],
            flanges=[
                Flange(**{**vars(each), "holes": [FlangeHole(**vars(hole)) for hole in each.holes]})
                for each in datums.flanges
            ],
            angle=None if angle is None else DatumAngle(of=angle[0], angle_deg=angle[1]),
            faces=[DatumFace(**vars(each)) for each in datums.faces],
        )

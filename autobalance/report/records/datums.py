"""Keyways, flanges and faces that can be touched."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, Self

from autobalance.declare import (
    ABSENT,
    Absent,
    Angle,
    NotNegative,
    Positive,
    record,
)

if TYPE_CHECKING:
    from autobalance.crank import datums as crank_datums


def _fields(datum: object) -> dict[str, Any]:
    """Return the values of a datum; a drawn one has no standard errors."""
    return {key: ABSENT if value is None and "_pm_" in key else value for key, value in vars(datum).items()}


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
    angle_pm_deg: NotNegative | Absent = ABSENT
    width_pm_mm: NotNegative | Absent = ABSENT
    depth_pm_mm: NotNegative | Absent = ABSENT


@record
class FlangeHole:
    """A hole of a bolt circle."""

    angle_deg: Angle
    radius_mm: Positive
    diameter_mm: Positive
    angle_pm_deg: NotNegative | Absent = ABSENT
    radius_pm_mm: NotNegative | Absent = ABSENT
    diameter_pm_mm: NotNegative | Absent = ABSENT


@record
class Flange:
    """A disc at an end of the crank, its outer face (null: not plane) and its bolt circle."""

    end: Literal["-z", "+z"]
    diameter_mm: Positive
    face_z_mm: float | None
    holes: Sequence[FlangeHole]
    diameter_pm_mm: NotNegative | Absent = ABSENT
    face_z_pm_mm: NotNegative | Absent = ABSENT


@record
class DatumAngle:
    """Datum of the angles besides crankpin 1, and its own angle."""

    of: Literal["keyway", "flange_hole"]
    angle_deg: Angle


@record
class DatumFace:
    """A plane face square to the axis, from which z is measured."""

    of: Literal["flange", "web", "end"]
    name: str
    z_mm: float
    z_pm_mm: NotNegative | Absent = ABSENT


@record
class Datums:
    """Datums for setting up the crank, faces the best first; null or empty without any."""

    keyways: Sequence[Keyway]
    flanges: Sequence[Flange]
    angle: DatumAngle | None
    faces: Sequence[DatumFace]

    @classmethod
    def of(cls, datums: crank_datums.Datums) -> Self:
        angle = datums.angle
        return cls(
            keyways=[Keyway(**_fields(each)) for each in datums.keyways],
            flanges=[
                Flange(**{**_fields(each), "holes": [FlangeHole(**_fields(hole)) for hole in each.holes]})
                for each in datums.flanges
            ],
            angle=None if angle is None else DatumAngle(of=angle[0], angle_deg=angle[1]),
            faces=[DatumFace(**_fields(each)) for each in datums.faces],
        )

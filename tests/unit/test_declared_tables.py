"""Tables declared as dataclasses: their keys, and what is made of what was read."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

import pytest

from autobalance.declare import (
    ANY,
    FILLED,
    MM,
    POSITIVE,
    REQUIRED,
    RPM,
    Degrees,
    InFile,
    Key,
    Named,
    TypedIn,
    keys_of,
    made,
)
from autobalance.errors import JobError
from autobalance.toml_files.keys import read


@dataclass(frozen=True)
class Hole:
    """A table in a table."""

    z_m: Annotated[float, MM, "where"]
    angle_rad: Annotated[Degrees, "of its axis"] = math.pi
    from_: Annotated[int, Named("from"), POSITIVE, "number of the first"] = 1


@dataclass(frozen=True)
class Options:
    """A table that is there with its defaults."""

    share: Annotated[float, TypedIn("share"), InFile(usual="a half"), "how much"] = 0.5


@dataclass(frozen=True)
class Plate:
    """A file."""

    file: str
    speed_rad_s: Annotated[tuple[float, ...], RPM, POSITIVE, InFile(not_empty="name one"), "speeds"]
    holes: Annotated[tuple[Hole, ...], "all of them"] = ()
    deepest: Annotated[Hole | None, "the one to begin with"] = None
    options: Annotated[Options, "further ones"] = field(default_factory=Options)


HOLE = (
    Key("z_mm", float, "where"),
    Key("angle_deg", float, "of its axis", ANY, 180.0),
    Key("from", int, "number of the first", POSITIVE, 1),
)


def test_keys_are_those_of_the_annotated_fields() -> None:
    assert keys_of(Plate) == (
        Key("speed_rpm", tuple[float, ...], "speeds", POSITIVE, REQUIRED, not_empty="name one"),
        Key("holes", None, "all of them", ANY, (), keys=HOLE, many=True),
        Key("deepest", None, "the one to begin with", ANY, None, keys=HOLE),
        Key(
            "options",
            None,
            "further ones",
            ANY,
            FILLED,
            keys=(Key("share", float, "how much", ANY, 0.5, typed="share", usual="a half"),),
        ),
    )


def test_what_was_read_is_made_in_the_units_of_the_fields() -> None:
    raw = {"speed_rpm": [60.0, 120], "holes": [{"z_mm": 7.0, "from": 3}, {"z_mm": 8.0, "angle_deg": 90}]}
    plate = made(Plate, read(raw, keys_of(Plate)), file="a.toml")
    assert plate.speed_rad_s == pytest.approx((2.0 * math.pi, 4.0 * math.pi), rel=1e-15)
    first, second = plate.holes
    assert [first.z_m, second.z_m] == pytest.approx([7e-3, 8e-3])
    assert first.from_ == 3
    assert (first.angle_rad, second.angle_rad) == (math.pi, math.pi / 2.0)
    assert (plate.deepest, plate.options, plate.file) == (None, Options(0.5), "a.toml")
    assert isinstance(first.from_, int)


def test_what_breaks_a_mark_is_refused_with_its_place() -> None:
    with pytest.raises(JobError, match=r"^holes\[1\]\.from is 0; must be > 0"):
        read({"speed_rpm": [1.0], "holes": [{"z_mm": 1.0, "from": 0}]}, keys_of(Plate))
    with pytest.raises(JobError, match=r"speed_rpm is an empty list; name one"):
        read({"speed_rpm": []}, keys_of(Plate))

"""``MACHINE.toml`` of ``nc``: a machine tool, its rotary axis, its zero and its tools."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from autobalance.declare import NOT_NEGATIVE, POSITIVE, Key, Range, Values
from autobalance.errors import JobError
from autobalance.toml_files.document import text_of, toml_of
from autobalance.toml_files.keys import named_in, read
from autobalance.toml_files.typed_units import in_base_units, length_mm

ToolKind = Literal["drill", "end_mill", "turning"]
LENGTHS = 1e4
POINT = Range("must be 30 to 180", least=30.0, most=180.0)
SIGN = Range("must be 1 or -1", one_of=(1, -1))
LENGTH = Range(f"must be > 0 and at most {LENGTHS:g}", above=0.0, most=LENGTHS)
TOOL_NUMBER = Range("must be 1 to 9999", least=1, most=9999)
PROGRAM = Range("must be 1 to 9990", least=1, most=9990)

MACHINE_PART = (
    Key("post", str, "dialect of the programs: linuxcnc, or fanuc (Fanuc and Haas)"),
    Key("max_rpm", float, "highest spindle speed", POSITIVE),
    Key("program_number", int, "fanuc: O-number of the first set-up, then one more each", PROGRAM, 1000),
    Key("coolant", str, 'code that turns it on; "" for none', default="M8"),
    Key("rapid_mm_min", float, "for the time only", POSITIVE, 15000.0),
    Key(
        "travel_mm",
        tuple[float, float, float],
        "travel of X, Y and Z that programs must keep to",
        POSITIVE,
        None,
    ),
)
ROTARY_PART = (
    Key("letter", Literal["A", "B", "C"], "letter of the rotary axis", default="A"),
    Key("sign", int, "direction of the angle on this machine", SIGN, 1),
    Key("unclamp", str, "code before the axis turns", default=""),
    Key("clamp", str, "code after it has turned", default=""),
)
ZERO_PART = (
    Key("angle", float | str, '"crankpin 1", "keyway", or degrees in the rotor frame'),
    Key("z_mm", float | str, '"crankpin 1", the name of a datum face, or mm in the rotor frame'),
    Key("clearance_mm", float, "clearance of tool and holder from metal on rapids", POSITIVE, 5.0),
    Key("finish_mm", float, "left on every depth, for a first try", NOT_NEGATIVE, 0.0),
)
TOOL_PART = (
    Key("number", int, "T and H", TOOL_NUMBER),
    Key("kind", ToolKind, "drill, end_mill or turning"),
    Key("diameter_mm", float, "diameter of drill or mill", LENGTH, None),
    Key("point_deg", float, "point angle of a drill; 180: flat", POINT, 118.0),
    Key("flute_mm", float, "cutting length; not for a turning tool", LENGTH, None),
    Key("stick_out_mm", float, "from the holder's face to the tip", LENGTH),
    Key(
        "holder",
        tuple[tuple[float, float], ...],
        "diameter and length of each step, from the tool's side",
        LENGTH,
    ),
    Key("rpm", float, "spindle speed; or cutting_m_min", POSITIVE, None),
    Key("cutting_m_min", float, "cutting speed", POSITIVE, None),
    Key("feed_mm_min", float, "feed; or feed_mm_rev", POSITIVE, None),
    Key("feed_mm_rev", float, "feed of a turn of the spindle", POSITIVE, None),
    Key("peck_mm", float, "drill: depth of a peck; 0: in one go", NOT_NEGATIVE, 0.0),
    Key("step_down_mm", float, "mills and lathe: depth of a pass", LENGTH, 1.0),
    Key("step_over_mm", float, "mills: width of a pass; default 0.4 of the diameter", LENGTH, None),
    Key("nose_radius_mm", float, "lathe", NOT_NEGATIVE, 0.4),
)
MACHINE_TOOL_KEYS = (
    Key("machine", says="the machine tool", keys=MACHINE_PART),
    Key("rotary", says="left out: radial cuts are not programmed", keys=ROTARY_PART, default=None),
    Key("zero", says="position of the machine's zero on the crank", keys=ZERO_PART),
    Key("tool", says="tools available", keys=TOOL_PART, many=True),
)


@dataclass(frozen=True)
class CuttingTool:
    """A tool in its holder: lengths in mm, speed in 1/min, feed in mm/min, holder as (diameter, length)."""

    number: int
    kind: ToolKind
    diameter_mm: float
    point_deg: float
    flute_mm: float
    stick_out_mm: float
    holder: tuple[tuple[float, float], ...]
    rpm: float | None
    cutting_m_min: float | None
    feed_mm_min: float | None
    feed_mm_rev: float | None
    peck_mm: float
    step_down_mm: float
    step_over_mm: float
    nose_radius_mm: float

    @property
    def radius_mm(self) -> float:
        return 0.5 * self.diameter_mm

    @property
    def is_drill(self) -> bool:
        return self.kind == "drill"

    @property
    def point_mm(self) -> float:
        """Length of a drill's point."""
        return 0.0 if not self.is_drill else self.radius_mm / math.tan(math.radians(0.5 * self.point_deg))

    def speed_rpm(self, diameter_mm: float, most_rpm: float) -> float:
        """Return the spindle's speed where a diameter cuts; a cutting speed is held to the machine's most."""
        if self.rpm is not None:
            return self.rpm
        assert self.cutting_m_min is not None  # one of the two is given
        return min(1000.0 * self.cutting_m_min / (math.pi * diameter_mm), most_rpm)

    def feed(self, speed_rpm: float) -> float:
        """Return the feed at a speed [mm/min]."""
        if self.feed_mm_min is not None:
            return self.feed_mm_min
        assert self.feed_mm_rev is not None  # one of the two is given
        return self.feed_mm_rev * speed_rpm


@dataclass(frozen=True)
class Rotary:
    """The rotary axis."""

    letter: str
    sign: int
    unclamp: str
    clamp: str


@dataclass(frozen=True)
class MachineTool:
    """The file: all its keys."""

    values: Values
    post: str
    max_rpm: float
    program_number: int
    coolant: str
    rapid_mm_min: float
    travel_mm: tuple[float, float, float] | None
    rotary: Rotary | None
    zero_angle: float | str
    zero_z: float | str
    clearance_mm: float
    finish_mm: float
    tools: tuple[CuttingTool, ...]


def read_machine_tool(source: str | Path | Mapping[str, Any]) -> MachineTool:
    """Read a machine tool's file, or its structure.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If a key is unknown, missing or impossible, or two tools have one number.
    """
    if isinstance(source, Mapping):
        return _machine_tool(_based(source))
    path = Path(source)
    raw = toml_of(text_of(path, "machine file"), path.name)
    with named_in(source):
        return _machine_tool(_based(raw))


def _based(raw: Mapping[str, Any]) -> Values:
    """Return the values in mm; ``zero.z_mm`` may be a name, which is not a length."""
    zero = raw.get("zero")
    if not isinstance(zero, Mapping) or not isinstance(zero.get("z_mm"), str):
        return read(in_base_units(raw), MACHINE_TOOL_KEYS)
    place: float | str = zero["z_mm"]
    with suppress(JobError):
        place = length_mm(zero["z_mm"], "zero.z_mm")
    without = {key: value for key, value in zero.items() if key != "z_mm"}
    based = in_base_units({**raw, "zero": without})
    return read({**based, "zero": {**based["zero"], "z_mm": place}}, MACHINE_TOOL_KEYS)


def _machine_tool(values: Values) -> MachineTool:
    machine, rotary, zero = values["machine"], values["rotary"], values["zero"]
    tools = [_tool(each, f"tool[{place}]") for place, each in enumerate(values["tool"], 1)]
    for place, tool in enumerate(tools, 1):
        if any(tool.number == other.number for other in tools[: place - 1]):
            raise JobError(
                f"tool[{place}].number is {tool.number}, which another tool has; expected one of its own"
            )
        if tool.rpm is not None and tool.rpm > machine["max_rpm"]:
            raise JobError(
                f"tool[{place}].rpm is {tool.rpm:g}; "
                f"expected at most machine.max_rpm = {machine['max_rpm']:g}"
            )
    return MachineTool(
        values,
        machine["post"],
        machine["max_rpm"],
        machine["program_number"],
        machine["coolant"].strip(),
        machine["rapid_mm_min"],
        machine["travel_mm"],
        None if rotary is None else Rotary(**rotary),
        zero["angle"],
        zero["z_mm"],
        zero["clearance_mm"],
        zero["finish_mm"],
        tuple(tools),
    )


def _tool(values: Values, place: str) -> CuttingTool:
    for one, other in (("rpm", "cutting_m_min"), ("feed_mm_min", "feed_mm_rev")):
        if (values[one] is None) == (values[other] is None):
            count = "neither" if values[one] is None else "both"
            raise JobError(f"{place} has {count} of {one} and {other}; expected one of them")
    if values["kind"] != "turning" and values["diameter_mm"] is None:
        raise JobError(f"{place}.diameter_mm is missing; a {values['kind']} needs it")
    if not values["holder"]:
        raise JobError(f"{place}.holder is empty; expected [[diameter, length], ...] from the tool's side")
    if values["kind"] == "turning":
        values = {**values, "flute_mm": values["flute_mm"] or values["stick_out_mm"]}
    elif values["flute_mm"] is None:
        raise JobError(f"{place}.flute_mm is missing; a {values['kind']} needs it")
    if values["flute_mm"] > values["stick_out_mm"]:
        raise JobError(
            f"{place}.flute_mm is {values['flute_mm']:g}; "
            f"expected at most stick_out_mm = {values['stick_out_mm']:g}"
        )
    nose = values["nose_radius_mm"]
    diameter = values["diameter_mm"] or max(2.0 * nose, 1.0)
    over = values["step_over_mm"] or 0.4 * diameter
    if values["kind"] == "end_mill" and over > diameter:
        raise JobError(f"{place}.step_over_mm is {over:g}; expected at most the diameter, {diameter:g}")
    return CuttingTool(**{**values, "diameter_mm": diameter, "step_over_mm": over})

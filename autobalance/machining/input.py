"""``MACHINE.toml``: the machine tool, its set-ups, its blocks of a program."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.declare import NOT_NEGATIVE, POSITIVE, InFile, Key, Range, Values, keys_of, made
from autobalance.errors import JobError
from autobalance.toml_files.document import text_of, toml_of
from autobalance.toml_files.keys import named_in, read
from autobalance.toml_files.typed_units import in_base_units, length_mm
from autobalance.types import Array
from autobalance.value_classes import dataclass

# ``MACHINE.toml`` of ``nc``: a machine tool, its rotary axis, its zero and its tools.


ToolKind = Literal["drill", "end_mill", "turning"]
LENGTHS = 1e4
POINT = Range("must be 30 to 180", least=30.0, most=180.0)
SIGN = Range("must be 1 or -1", one_of=(1, -1))
LENGTH = Range(f"must be > 0 and at most {LENGTHS:g}", above=0.0, most=LENGTHS)
TOOL_NUMBER = Range("must be 1 to 9999", least=1, most=9999)
PROGRAM = Range("must be 1 to 9990", least=1, most=9990)


@dataclass(frozen=True)
class Spindle:
    """``[machine]``: the machine tool."""

    post: Annotated[str, "dialect of the programs: linuxcnc, or fanuc (Fanuc and Haas)"]
    max_rpm: Annotated[float, POSITIVE, "highest spindle speed"]
    program_number: Annotated[int, PROGRAM, "fanuc: O-number of the first set-up, then one more each"] = 1000
    coolant: Annotated[str, 'code that turns it on; "" for none'] = "M8"
    rapid_mm_min: Annotated[float, POSITIVE, "rapid feed, for the time only"] = 15000.0
    travel_mm: Annotated[
        tuple[float, float, float] | None, POSITIVE, "travel of X, Y and Z that programs must keep to"
    ] = None


@dataclass(frozen=True)
class Rotary:
    """``[rotary]``: the rotary axis."""

    letter: Annotated[Literal["A", "B", "C"], "letter of the rotary axis"] = "A"
    sign: Annotated[int, SIGN, "direction of the angle on this machine"] = 1
    unclamp: Annotated[str, "code before the axis turns"] = ""
    clamp: Annotated[str, "code after it has turned"] = ""


@dataclass(frozen=True)
class MachineZero:
    """``[zero]``: the machine's zero on the crank."""

    angle: Annotated[float | str, '"crankpin 1", "keyway", or degrees in the rotor frame']
    z_mm: Annotated[float | str, '"crankpin 1", the name of a datum face, or mm in the rotor frame']
    clearance_mm: Annotated[float, POSITIVE, "clearance of tool and holder from metal on rapids"] = 5.0
    finish_mm: Annotated[float, NOT_NEGATIVE, "left on every depth, for a first try"] = 0.0


@dataclass(frozen=True, kw_only=True)
class CuttingTool:
    """``[[tool]]``: a tool in its holder, the holder as (diameter, length) of each step."""

    number: Annotated[int, TOOL_NUMBER, "T and H"]
    kind: Annotated[ToolKind, "drill, end_mill or turning"]
    diameter_mm: Annotated[float, LENGTH, InFile(filled=True), "diameter of drill or mill"]
    point_deg: Annotated[float, POINT, "point angle of a drill; 180: flat"] = 118.0
    flute_mm: Annotated[float, LENGTH, InFile(filled=True), "cutting length; not for a turning tool"]
    stick_out_mm: Annotated[float, LENGTH, "length from the holder's face to the tip"]
    holder: Annotated[
        tuple[tuple[float, float], ...], LENGTH, "diameter and length of each step, from the tool's side"
    ]
    rpm: Annotated[float | None, POSITIVE, "spindle speed; or cutting_m_min"] = None
    cutting_m_min: Annotated[float | None, POSITIVE, "cutting speed"] = None
    feed_mm_min: Annotated[float | None, POSITIVE, "feed; or feed_mm_rev"] = None
    feed_mm_rev: Annotated[float | None, POSITIVE, "feed of a turn of the spindle"] = None
    peck_mm: Annotated[float, NOT_NEGATIVE, "drill: depth of a peck; 0: in one go"] = 0.0
    step_down_mm: Annotated[float, LENGTH, "mills and lathe: depth of a pass"] = 1.0
    step_over_mm: Annotated[
        float, LENGTH, InFile(filled=True), "mills: width of a pass; default 0.4 of the diameter"
    ]
    nose_radius_mm: Annotated[float, NOT_NEGATIVE, "lathe"] = 0.4

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


MACHINE_TOOL_KEYS = (
    Key("machine", says="the machine tool", keys=keys_of(Spindle)),
    Key("rotary", says="left out: radial cuts are not programmed", keys=keys_of(Rotary), default=None),
    Key("zero", says="position of the machine's zero on the crank", keys=keys_of(MachineZero)),
    Key("tool", says="tools available", keys=keys_of(CuttingTool), many=True),
)


@dataclass(frozen=True)
class MachineTool:
    """The file; ``values`` are all of its keys."""

    values: Values
    spindle: Spindle
    rotary: Rotary | None
    zero: MachineZero
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
    machine, rotary = made(Spindle, values["machine"]), values["rotary"]
    tools = [_tool(each, f"tool[{place}]") for place, each in enumerate(values["tool"], 1)]
    for place, tool in enumerate(tools, 1):
        if any(tool.number == other.number for other in tools[: place - 1]):
            raise JobError(
                f"tool[{place}].number is {tool.number}, which another tool has; give each its own number"
            )
        if tool.rpm is not None and tool.rpm > machine.max_rpm:
            raise JobError(
                f"tool[{place}].rpm is {tool.rpm:g}; expected at most machine.max_rpm = {machine.max_rpm:g}"
            )
    return MachineTool(
        values,
        replace(machine, coolant=machine.coolant.strip()),
        None if rotary is None else made(Rotary, rotary),
        made(MachineZero, values["zero"]),
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
    return made(CuttingTool, values, diameter_mm=diameter, step_over_mm=over)


# Clamping of a crank: set-ups, their axes on the rotor, and the machine's zero.


SetupName = Literal["R", "T", "B", "L"]
CLAMPING_TEXTS = {
    "R": "along the machine's X between centres, on the rotary axis, rotor +z = machine +X; spindle along Z",
    "T": "upright, rotor +z up along machine Z, machine X towards the angle zero",
    "B": "turned over about machine X, rotor -z up along machine Z, machine X towards the angle zero",
    "L": "in the lathe, rotor +z = machine Z, diameter programming",
}


@dataclass(frozen=True)
class NcZero:
    """The machine's zero in the rotor frame, and in words the datum that is touched for it."""

    angle_deg: float
    z_mm: float
    angle_of: str
    z_of: str


def zero_of(machine: MachineTool, anatomy: Anatomy) -> NcZero:
    """Return the zero that a machine's file asks for on a crank.

    Raises
    ------
    JobError
        If the crank has not what it names.
    """
    angle, angle_of = _angle(machine.zero.angle, anatomy)
    z, z_of = _place(machine.zero.z_mm, anatomy)
    return NcZero(angle, z, angle_of, z_of)


def _crankpin(name: str, anatomy: Anatomy) -> int | None:
    words = name.lower().split()
    if len(words) == 2 and words[0] == "crankpin" and words[1].isdecimal():
        return next((k for k, throw in enumerate(anatomy.throws) if throw.number == int(words[1])), None)
    return None


def _angle(stated: float | str, anatomy: Anatomy) -> tuple[float, str]:
    if not isinstance(stated, str):
        return float(stated), f"{stated:g} deg from crankpin 1"
    throw = _crankpin(stated, anatomy)
    if throw is not None:
        x, y = anatomy.throws[throw].direction
        return math.degrees(math.atan2(float(y), float(x))), f"crankpin {anatomy.throws[throw].number}"
    datums = anatomy.datums
    if stated.lower() == "keyway" and datums is not None and datums.keyways:
        longest = max(datums.keyways, key=lambda key: round(key.z_max_mm - key.z_min_mm, 3))
        return longest.angle_deg, "the keyway's middle"
    if stated.lower() == "keyway":
        raise JobError(
            'zero.angle is "keyway"; no keyway was found on this crank; expected "crankpin 1" or degrees'
        )
    raise JobError(f'zero.angle is "{stated}"; expected "crankpin 1", "keyway" or degrees')


def _place(stated: float | str, anatomy: Anatomy) -> tuple[float, str]:
    if not isinstance(stated, str):
        return float(stated), f"z = {stated:g} mm from the middle of crankpin 1"
    throw = _crankpin(stated, anatomy)
    if throw is not None:
        pin = anatomy.throws[throw]
        return float(pin.crankpin.centre_mm[2]), f"the middle of crankpin {pin.number}"
    faces = () if anatomy.datums is None else anatomy.datums.faces
    if stated == "F":
        if faces:
            return faces[0].z_mm, f"face F, the {faces[0].name}"
        web = min(anatomy.webs, key=lambda each: each.z_min_mm)
        return web.z_min_mm, f"face F, the -z face of web {web.number}"
    named = next((face for face in faces if face.name == stated), None)
    if named is not None:
        return named.z_mm, f"the {named.name}"
    known = ", ".join(f'"{face.name}"' for face in faces)
    raise JobError(
        f'zero.z_mm is "{stated}"; expected "crankpin 1", "F", mm' + (f", or one of {known}" if known else "")
    )


def placement(setup: SetupName, zero: NcZero, rotary_sign: int = 1, rotary_deg: float = 0.0) -> Array:
    """Return the motion (4, 4) from a set-up's machine coordinates to the rotor frame.

    In L the machine's X is a radius here, towards the angle zero.
    """
    turn = math.radians(zero.angle_deg + (rotary_sign * rotary_deg if setup == "R" else 0.0))
    out, across = (
        np.array([math.cos(turn), math.sin(turn), 0.0]),
        np.array([-math.sin(turn), math.cos(turn), 0.0]),
    )
    along = np.array([0.0, 0.0, 1.0])
    axes = {
        "R": (along, -across, out),
        "T": (out, across, along),
        "B": (out, -across, -along),
        "L": (out, across, along),
    }[setup]
    frame = np.eye(4)
    frame[:3, :3] = np.stack(axes, axis=1)
    frame[2, 3] = zero.z_mm
    return frame


def inverse(motion: Array) -> Array:
    """Return the inverse of a rigid motion (4, 4)."""
    back = np.eye(4)
    back[:3, :3] = motion[:3, :3].T
    back[:3, 3] = -motion[:3, :3].T @ motion[:3, 3]
    return back


def rotary_deg(angle_deg: float, zero: NcZero, sign: int) -> float:
    """Return the word in [0, 360) that brings an angle of the rotor under the spindle, to 4 decimals."""
    return round(sign * (angle_deg - zero.angle_deg) % 360.0, 4) % 360.0


# Moves and commands of a program, before a post writes them in the machine's dialect.


@dataclass(frozen=True)
class Note:
    """A comment."""

    text: str


@dataclass(frozen=True)
class ToolChange:
    """Another tool, its speed, and the height that it comes to first."""

    tool: CuttingTool
    rpm: float
    safe_mm: float


@dataclass(frozen=True)
class Index:
    """The rotary axis turns to an angle: unclamp, turn, clamp."""

    angle_deg: float


@dataclass(frozen=True)
class Go:
    """A straight move to what is given; ``feed`` None: in rapid."""

    x: float | None = None
    y: float | None = None
    z: float | None = None
    a: float | None = None
    feed: float | None = None


@dataclass(frozen=True)
class DrillCycle:
    """A drilling cycle at a place; ``peck_mm`` 0: in one go."""

    x: float
    y: float
    bottom: float
    retract: float
    feed: float
    peck_mm: float


@dataclass(frozen=True)
class Unclamp:
    """The rotary axis is freed to turn under a cutter."""


@dataclass(frozen=True)
class Clamp:
    """The rotary axis is held again."""


@dataclass(frozen=True)
class Retreat:
    """Back to the safe height, spindle and coolant off."""

    safe_mm: float


Block = Note | ToolChange | Index | Go | DrillCycle | Unclamp | Clamp | Retreat

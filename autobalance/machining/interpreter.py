"""Reading back of a program: its moves, and the bodies that its tools sweep."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from autobalance.errors import FormatError
from autobalance.machining.input import CuttingTool
from autobalance.value_classes import dataclass

# Reads the text of a program again, line by line, as a control does, independently of its writer.


WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))")
COMMENT = re.compile(r"\(([^()]*)\)|;(.*)$")
CUT = re.compile(r"\bcut (\d+)\b", re.IGNORECASE)
AXES = "XYZABC"
BACK_MM = 0.5
"""Distance above the last peck to which a drill returns in rapid."""
IGNORED_G_CODES = {7.0, 17.0, 21.0, 40.0, 49.0, 54.0, 90.0, 94.0, 98.0}


@dataclass(frozen=True)
class ToolPlace:
    """Place of a tool's tip; None: not known yet. x is as in the word: in a lathe a diameter."""

    x: float | None = None
    y: float | None = None
    z: float | None = None
    turned_deg: float = 0.0


@dataclass(frozen=True)
class Move:
    """A straight move of a tool.

    ``in_hole``: out of, or back into, the hole just being made. ``cut`` is the number in the last comment.
    """

    line: int
    tool: int
    cut: int | None
    start: ToolPlace
    end: ToolPlace
    rapid: bool
    feed: float
    spinning: bool
    in_hole: bool = False


@dataclass
class _State:
    place: ToolPlace = ToolPlace()
    tool: int = 0
    cut: int | None = None
    motion: float = 0.0
    feed: float = 0.0
    spinning: bool = False
    bottom: float = 0.0
    retract: float = 0.0
    peck: float = 0.0
    return_high: bool = True


def read_program(text: str, rotary: str = "A") -> list[Move]:
    """Return the moves of a program.

    Parameters
    ----------
    text : str
    rotary : str
        Letter of the rotary axis.

    Raises
    ------
    FormatError
        If a line has a code that no program of ours has, or the program does not end.
    """
    state, moves, ended = _State(), list[Move](), False
    for number, line in enumerate(text.splitlines(), 1):
        for comment in COMMENT.finditer(line):
            cut_mark = CUT.search(comment[1] or comment[2] or "")
            if cut_mark:
                state.cut = int(cut_mark[1])
        code = COMMENT.sub("", line).strip()
        if code in ("", "%") or re.fullmatch(r"O\d+", code):
            continue
        if ended:
            raise FormatError(f"line {number}: there is more after M30")
        words = WORD.findall(code)
        if WORD.sub("", code).strip():
            raise FormatError(f"line {number} is not understood: {code}")
        ended = _line(state, [(letter, float(value)) for letter, value in words], number, rotary, moves)
    if not ended:
        raise FormatError("the program has no M30")
    return moves


def _line(state: _State, words: list[tuple[str, float]], number: int, rotary: str, moves: list[Move]) -> bool:
    values: dict[str, float] = {}
    is_motion, ended = False, False
    for letter, value in words:
        if letter == "G":
            is_motion |= _general(state, value, number)
        elif letter == "M":
            ended |= _machine(state, value)
        elif letter == "T":
            state.tool = int(value)
        elif letter == "F":
            state.feed = value
        elif letter in "XYZRQ" or letter == rotary:
            values["W" if letter == rotary else letter] = value
        elif letter not in "HSPD":
            raise FormatError(f"line {number} has a word {letter} that is not understood")
    if values or is_motion:
        moves.extend(_moved(state, values, number))
    return ended


def _general(state: _State, value: float, number: int) -> bool:
    if value in (0.0, 1.0, 81.0, 83.0):
        state.motion = value
        return False
    if value == 80.0:
        state.motion = 0.0
    elif value == 99.0:
        state.return_high = False
    elif value == 98.0:
        state.return_high = True
    elif value not in IGNORED_G_CODES and value != 43.0:
        raise FormatError(f"line {number} has G{value:g}, which is not understood")
    return False


def _machine(state: _State, value: float) -> bool:
    if value in (3.0, 4.0):
        state.spinning = True
    elif value == 5.0:
        state.spinning = False
    elif value == 6.0:
        state.place = ToolPlace(turned_deg=state.place.turned_deg)
    return value in (2.0, 30.0)


def _moved(state: _State, values: dict[str, float], number: int) -> Iterator[Move]:
    if state.motion in (81.0, 83.0):
        yield from _cycle(state, values, number)
        return
    end = replace(
        state.place,
        x=values.get("X", state.place.x),
        y=values.get("Y", state.place.y),
        z=values.get("Z", state.place.z),
        turned_deg=values.get("W", state.place.turned_deg),
    )
    yield _go(state, end, number, state.motion == 0.0)


def _go(state: _State, end: ToolPlace, number: int, rapid: bool, in_hole: bool = False) -> Move:
    move = Move(number, state.tool, state.cut, state.place, end, rapid, state.feed, state.spinning, in_hole)
    state.place = end
    return move


def _cycle(state: _State, values: dict[str, float], number: int) -> Iterator[Move]:
    state.bottom, state.retract = values.get("Z", state.bottom), values.get("R", state.retract)
    state.peck = values.get("Q", state.peck)
    high = state.place.z
    if high is None:
        raise FormatError(f"line {number}: a cycle begins at no known height")
    over = replace(state.place, x=values.get("X", state.place.x), y=values.get("Y", state.place.y))
    yield _go(state, over, number, True)
    top = replace(over, z=state.retract)
    yield _go(state, top, number, True)
    if state.motion == 81.0 or state.peck <= 0.0:
        yield _go(state, replace(over, z=state.bottom), number, False)
    else:
        depth = state.retract
        while depth > state.bottom:
            depth = max(depth - state.peck, state.bottom)
            yield _go(state, replace(over, z=depth), number, False)
            if depth > state.bottom:
                yield _go(state, top, number, True, True)
                yield _go(state, replace(over, z=min(depth + BACK_MM, state.retract)), number, True, True)
    yield _go(state, top, number, True, True)
    if state.return_high:
        yield _go(state, replace(over, z=max(high, state.retract)), number, True)


# The shape of a tool in its holder, as round steps over the tip.


@dataclass(frozen=True)
class ToolStep:
    """A round part of tool or holder: its radius, and where it begins and ends over the tip [mm]."""

    name: str
    radius_mm: float
    low_mm: float
    high_mm: float
    cuts: bool


def steps_of(tool: CuttingTool) -> tuple[ToolStep, ...]:
    """Return the parts of a tool from its tip up: flutes, shank, holder."""
    radius = tool.radius_mm
    steps = [ToolStep("flute", radius, 0.0, tool.flute_mm + tool.point_mm, True)]
    if tool.stick_out_mm > tool.flute_mm + tool.point_mm:
        steps.append(ToolStep("shank", radius, tool.flute_mm + tool.point_mm, tool.stick_out_mm, False))
    at = tool.stick_out_mm
    for diameter, length in tool.holder:
        steps.append(ToolStep("holder", 0.5 * diameter, at, at + length, False))
        at += length
    return tuple(steps)


def widest_mm(tool: CuttingTool) -> float:
    """Return the radius of the widest part."""
    return max(step.radius_mm for step in steps_of(tool))


def length_mm(tool: CuttingTool) -> float:
    """Return the length of tool and holder from the tip."""
    return tool.stick_out_mm + sum(length for _, length in tool.holder)

"""The programs of a part: planned, written, read again from their text, simulated on the solid."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.correction.machining import HoleOperation
from autobalance.errors import JobError, SolidError
from autobalance.machining.area_moves import Listed, MachinedCrank, Stock
from autobalance.machining.input import CLAMPING_TEXTS, CuttingTool, MachineTool, NcZero, SetupName
from autobalance.machining.interpreter import Move, length_mm, read_program
from autobalance.machining.planner import NcPlan, Planner, Setup, tool_words
from autobalance.machining.posts import post_named
from autobalance.machining.simulator import Simulation, Simulator, operation_body
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.runtime import Notify
from autobalance.solid.csg.solid import union
from autobalance.value_classes import dataclass

THIN_MM = 0.02
"""Half the thickness of what is rounding between two solids, not metal: facets of one round wall."""
THIN_MM3 = THIN_MM**3
"""Volume of such a piece: what a cut that is planned to take nothing may seem to take."""
GOUGED_SHARE = 2e-3
"""Share of the metal cut that may be taken beyond the plan before a program is refused."""
HOLE_SHARE, AREA_SHARE = 5e-3, 0.1
"""Shares by which what a program takes of a hole, or of another cut, may differ from what is planned."""
MOST_TOLD = 3
TOOL_CHANGE_S = 8.0
INDEX_S = 2.0


@dataclass(frozen=True, eq=False)
class Program:
    """The program of a set-up: its file, its text, and the moves that were read from it."""

    setup: Setup
    file: str
    text: str
    moves: tuple[Move, ...]
    time_s: float

    @property
    def name(self) -> SetupName:
        """The set-up's name."""
        return self.setup.name


@dataclass(frozen=True, eq=False)
class NcRun:
    """All programs, and what they do to the solid.

    ``residual`` is what the programs leave, ``taken_g`` what each cut takes; ``gouged_mm3`` and
    ``left_mm3`` are the metal that is missing, or still there, compared with the corrected solid.
    """

    part: MachinedCrank
    machine: MachineTool
    plan: NcPlan
    programs: tuple[Program, ...]
    residual: Unbalance
    taken_g: dict[int, float]
    mass_difference_g: float
    gouged_mm3: float
    left_mm3: float

    @property
    def zero(self) -> NcZero:
        return self.plan.zero

    @property
    def used_share(self) -> float:
        """Residual as simulated, as a share of the permissible value."""
        return float(self.part.tolerance.used_share(self.residual))

    @property
    def is_complete(self) -> bool:
        """Whether every cut is programmed, and what is left is within tolerance."""
        return not self.plan.not_programmed and self.used_share <= 1.0


def nc_run(part: MachinedCrank, machine: MachineTool, progress: Notify = lambda _: None) -> NcRun:
    """Return the programs of a part on a machine, as simulated from their own text.

    Raises
    ------
    JobError
        If a tool is missing, the travel too short, or a move would hit.
    """
    post = post_named(machine.spindle.post)
    for lathe in (False, True):
        post(machine, lathe)  # refuses codes that it does not know
    if not any(cut.operation is not None for cut in part.cuts):
        raise JobError(
            f"{part.report.name} lists no cuts; expected a report with corrections that take metal"
        )
    progress("planning the programs")
    planner = Planner(part, machine)
    plan = planner.plan()
    letter = "A" if machine.rotary is None else machine.rotary.letter
    programs = []
    for place, setup in enumerate(plan.setups):
        writer = post(machine, setup.name == "L")
        file = f"setup-{setup.name}.{writer.ending}"
        text = writer.program(
            machine.spindle.program_number + place, head(part, machine, plan, setup), setup.blocks
        )
        moves = tuple(read_program(text, letter))
        programs.append(Program(setup, file, text, moves, time_s(moves, machine)))
    refuse_travel(programs, planner.space.stock, machine, plan.zero)
    progress("simulating the programs")
    return simulated(part, machine, plan, programs)


def head(part: MachinedCrank, machine: MachineTool, plan: NcPlan, setup: Setup) -> list[str]:
    """Return the comments that a program begins with."""
    zero = plan.zero
    return [
        f"autobalance: {part.name}, set-up {setup.name}: {CLAMPING_TEXTS[setup.name]}",
        f"report {part.report.name}, sha256",
        part.sha256,
        f"rotor mass {part.tolerance.rotor_mass_g:.1f} g",
        f"angle zero: {zero.angle_of}, {zero.angle_deg:.4f} deg in the rotor frame",
        f"z zero: {zero.z_of}, z = {zero.z_mm:.4f} in the rotor frame",
        f"safe height {setup.safe_mm:.4f}, clearance {machine.zero.clearance_mm:g} mm",
        *([f"{machine.zero.finish_mm:g} mm are left on every depth"] if machine.zero.finish_mm else []),
        *(f"T{tool.number} {tool_words(tool)}" for tool in setup.tools),
        "order of the cuts: " + ", ".join(str(cut.number) for cut, _ in setup.cuts),
        "run 100 mm above the part first; not proven on a machine",
    ]


def simulated(part: MachinedCrank, machine: MachineTool, plan: NcPlan, programs: Sequence[Program]) -> NcRun:
    """Return the effect of programs on a part, from their text alone.

    Raises
    ------
    JobError
        If a move would hit, or takes metal beyond the plan.
    """
    simulator = Simulator(Stock(part.before, part.anatomy), machine, plan.zero)
    for program in programs:
        simulator.run(program.name, program.moves)
    result = simulator.found
    if result.collisions:
        texts = list(dict.fromkeys(each.text for each in result.collisions))
        more = "" if len(texts) <= MOST_TOLD else f"; and {len(texts) - MOST_TOLD} more"
        into = "a longer tool, or a thinner holder"
        ways = {"longer flutes, or a relieved neck" if each.along else into for each in result.collisions}
        raise JobError("; ".join(texts[:MOST_TOLD]) + more + f"; expected {', or '.join(sorted(ways))}")
    expected = {cut.number: planned(part, cut) for cut in part.cuts}
    if machine.zero.finish_mm == 0.0:
        _refuse_missing(part, programs, result, expected)
    gouged, left = differences(part, plan, result)
    cut_mm3 = sum((each.mass_g for each in result.taken.values()), 0.0)
    if gouged > GOUGED_SHARE * cut_mm3 + THIN_MM3:
        raise JobError(
            f"the programs take {gouged:.3g} mm3 beyond the plan; expected a narrower tool, or other cuts"
        )
    density = part.density_g_mm3
    change = Moments.zero()
    difference = 0.0
    for cut in part.cuts:
        if cut.operation is None:
            continue
        took = result.taken.get(cut.number, Moments.zero())
        change = change + expected[cut.number].scaled(density) - took.scaled(density)
        if cut.number not in result.taken:
            change = change - cut.pressed_in
        else:
            difference += density * (took.mass_g - float(cut.item["removed_volume_mm3"]))
    return NcRun(
        part,
        machine,
        plan,
        tuple(programs),
        part.residual + Unbalance.of(change),
        {number: density * each.mass_g for number, each in result.taken.items() if number is not None},
        difference,
        gouged,
        left,
    )


def _refuse_missing(
    part: MachinedCrank, programs: Sequence[Program], simulation: Simulation, planned_mm3: dict[int, Moments]
) -> None:
    """Refuse programs that leave much of a cut standing.

    Raises
    ------
    JobError
        If there is one.
    """
    for program in programs:
        for cut, tool in program.setup.cuts:
            cut_mm3, due_mm3 = (
                simulation.taken.get(cut.number, Moments.zero()).mass_g,
                planned_mm3[cut.number].mass_g,
            )
            share = HOLE_SHARE if isinstance(cut.operation, HoleOperation) else AREA_SHARE
            if abs(cut_mm3 - due_mm3) > share * due_mm3 + THIN_MM3:
                density = part.density_g_mm3
                raise JobError(
                    f"cut {cut.number} with tool {tool.number} takes {density * cut_mm3:.4g} g of the "
                    f"{density * due_mm3:.4g} g planned; expected a tool that gets there, a narrower one say"
                )


def planned(part: MachinedCrank, cut: Listed) -> Moments:
    """Return the moments (density 1) of what a cut should take of the solid that is simulated."""
    operation = cut.operation
    if operation is None or isinstance(operation, str):
        return Moments.zero()
    return (part.before & operation_body(operation)).moments(1.0)


def differences(part: MachinedCrank, plan: NcPlan, simulation: Simulation) -> tuple[float, float]:
    """Return the metal that is missing of the corrected solid, and what of the plan is still there [mm³].

    What no program touches is as it was: only what tools took, and what they should take, is looked at.
    """
    left_out = {each.correction for each in plan.not_programmed}
    operations = [
        cut.operation
        for cut in part.cuts
        if cut.number not in left_out and cut.operation is not None and not isinstance(cut.operation, str)
    ]
    metal_cut = union([body for body, _ in simulation.stock.removed])
    due = part.before & union([operation_body(operation) for operation in operations])
    try:
        missing, more = part.after & metal_cut, (due - metal_cut) - part.after
    except SolidError as error:
        raise JobError(f"the simulated solid cannot be compared: {error}") from None
    gouged, still = (
        sum(piece.volume_mm3 for piece in each.thicker_pieces(THIN_MM)) if not each.is_empty else 0.0
        for each in (missing, more)
    )
    return float(gouged), float(still)


# --- time and travel ----------------------------------------------------------------------------------------


def time_s(moves: Sequence[Move], machine: MachineTool) -> float:
    """Return the running time of a program."""
    total, tool = 0.0, 0
    for move in moves:
        if move.tool != tool:
            tool, total = move.tool, total + TOOL_CHANGE_S
        turn = abs(move.end.turned_deg - move.start.turned_deg)
        if turn and move.rapid:
            total += INDEX_S
            continue
        ends = ((move.start.x, move.end.x), (move.start.y, move.end.y), (move.start.z, move.end.z))
        way = math.sqrt(sum((b - a) ** 2 for a, b in ends if a is not None and b is not None))
        speed = machine.spindle.rapid_mm_min if move.rapid else move.feed
        if speed > 0.0:
            total += 60.0 * (way or turn) / speed
    return total


def refuse_travel(programs: Sequence[Program], stock: Stock, machine: MachineTool, zero: NcZero) -> None:
    """Refuse programs that a machine has not the travel for, or that would drive a tool into the table.

    Raises
    ------
    JobError
        If there is one.
    """
    low, high = stock.ends_mm
    wide = 2.0 * stock.greatest_radius_mm
    for program in programs:
        name = program.name
        upright = name in ("T", "B")
        if upright:
            bottom = min((low - zero.z_mm), (high - zero.z_mm)) if name == "T" else zero.z_mm - high
            _refuse_table(program, bottom)
        if machine.spindle.travel_mm is None:
            continue
        x, y, z = machine.spindle.travel_mm
        length = high - low
        size = {"R": (length, 0.0), "L": (0.0, 0.0)}.get(name, (wide, wide))
        for letter, size_mm, there in (("X", size[0], x), ("Y", size[1], y)):
            if size_mm > there:
                raise JobError(
                    f"set-up {name} needs {size_mm:.1f} mm of {letter} for the crank; "
                    f"machine.travel_mm has {there:g}"
                )
        spans = {letter: _span(program.moves, letter) for letter in "XYZ"}
        scale = 0.5 if name == "L" else 1.0
        for letter, there in (("X", x), ("Y", y), ("Z", z)):
            span = spans[letter] * (scale if letter == "X" else 1.0)
            if span > there:
                raise JobError(
                    f"set-up {name} moves {span:.1f} mm along {letter}; machine.travel_mm has {there:g}"
                )
        if name != "L":
            longest = max(program.setup.tools, key=length_mm)
            size_mm = (length if upright else wide) + machine.zero.clearance_mm + longest.stick_out_mm
            if size_mm > z:
                raise JobError(
                    f"set-up {name} needs {size_mm:.1f} mm of Z for the crank and tool {longest.number}; "
                    f"machine.travel_mm has {z:g}"
                )


def _refuse_table(program: Program, bottom: float) -> None:
    for move in program.moves:
        if move.end.z is not None and move.end.z < bottom - 1e-6:
            raise JobError(
                f"set-up {program.name}: tool {move.tool} goes {bottom - move.end.z:.1f} mm below the "
                f"crank's end, into the table, at cut {move.cut}"
            )


def _span(moves: Sequence[Move], letter: str) -> float:
    values = [getattr(place, letter.lower()) for move in moves for place in (move.start, move.end)]
    known = np.array([value for value in values if value is not None])
    return float(np.ptp(known)) if len(known) else 0.0


def tool_table(tools: Sequence[CuttingTool]) -> str:
    """Return LinuxCNC's tool table, in mm; lengths are the user's to measure."""
    lines = [
        f"T{tool.number} P{tool.number} Z0.0000 D{tool.diameter_mm:.4f} ;{tool_words(tool)}"
        for tool in sorted(tools, key=lambda each: each.number)
    ]
    return "\n".join(lines) + "\n"

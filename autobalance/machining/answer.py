"""The report of `nc`: ``nc.json``, its text and pictures."""

from __future__ import annotations

import hashlib
import io
import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.correction.machining import HoleOperation
from autobalance.declare import ABSENT, Floats, NotNegative, Ordinal, Positive, decoded, record
from autobalance.machining.area_moves import Listed
from autobalance.machining.input import CLAMPING_TEXTS, NcZero, SetupName
from autobalance.machining.planner import NotProgrammed, tool_words
from autobalance.machining.run import NcRun, Program
from autobalance.report.records.answers import Head
from autobalance.report.records.balance import Unbalance
from autobalance.report.records.corrections import Correction
from autobalance.report.reportlab_alone import load_reportlab
from autobalance.wording import NO_VALUE, percent

# The report of `nc`: ``nc.json``.


@record
class NcSetup:
    """A set-up and its program."""

    name: SetupName
    file: str
    sha256: str
    post: str
    zero: NcZero
    tools: Sequence[Ordinal]
    cuts: Annotated[Sequence[Ordinal], "numbers of the report's corrections, in the order they are cut"]
    safe_mm: Annotated[float, "height over everything in the set-up's Z; in L a diameter"]
    time_s: NotNegative


@record
class NcResidual:
    """Residual unbalance after the programs, as judged."""

    resultant_g_mm: Floats
    magnitude_g_mm: NotNegative
    planes: Annotated[Sequence[Any], "as in a report"]


@record
class Simulated:
    """Effect of the programs on the solid, simulated from their text."""

    removed_mass_g: NotNegative
    mass_difference_g: Annotated[float, "to the mass that the report lists of these cuts"]
    residual: NcResidual
    used_share: Annotated[NotNegative, "largest judged value over its permissible value"]
    gouged_mm3: Annotated[NotNegative, "metal of the corrected solid that is missing"]
    left_mm3: Annotated[NotNegative, "metal still there of the cuts that are programmed"]


@record
class NcCut:
    """A correction and the tool that makes it."""

    correction: Ordinal
    setup: str
    tool: Ordinal
    removed_mass_g: Positive | float


@record
class NcReport(Head):
    """NC programs of a report's corrections."""

    command: Literal["nc"] = "nc"
    report: str
    report_sha256: str
    machine: Annotated[Mapping[str, Any], "the machine file, defaults filled in"]
    setups: Sequence[NcSetup]
    not_programmed: Sequence[NotProgrammed]
    simulated: Simulated
    collisions: Annotated[Sequence[str], "none: a program that would hit is not written"]
    corrections: Sequence[NcCut]
    warnings: Sequence[str]


# The report of ``nc``, written as ``nc.json``.


def nc_report(run: NcRun) -> NcReport:
    return NcReport(
        report=run.part.report.name,
        report_sha256=run.part.sha256,
        machine={**run.machine.values},
        setups=tuple(_setup(run, program) for program in run.programs),
        not_programmed=run.plan.not_programmed,
        simulated=_simulated(run),
        collisions=(),
        corrections=tuple(
            NcCut(
                correction=cut.number,
                setup=program.name,
                tool=tool.number,
                removed_mass_g=run.taken_g.get(cut.number, 0.0),
            )
            for program in run.programs
            for cut, tool in program.setup.cuts
        ),
        warnings=(),
    )


def _setup(run: NcRun, program: Program) -> NcSetup:
    setup = program.setup
    return NcSetup(
        name=program.name,
        file=program.file,
        sha256=hashlib.sha256(program.text.encode("ascii")).hexdigest(),
        post=run.machine.spindle.post,
        zero=run.zero,
        tools=tuple(tool.number for tool in setup.tools),
        cuts=tuple(cut.number for cut, _ in setup.cuts),
        safe_mm=setup.safe_mm,
        time_s=program.time_s,
    )


def _simulated(run: NcRun) -> Simulated:
    residual = Unbalance.of(run.residual, run.part.tolerance.places_mm)
    return Simulated(
        removed_mass_g=sum(run.taken_g.values()),
        mass_difference_g=run.mass_difference_g,
        residual=NcResidual(
            resultant_g_mm=residual.unbalance_g_mm,
            magnitude_g_mm=run.residual.magnitude_g_mm,
            planes=residual.planes,
        ),
        used_share=run.used_share,
        gouged_mm3=run.gouged_mm3,
        left_mm3=run.left_mm3,
    )


# Summary of ``nc`` as lines to read.


def nc_text(run: NcRun) -> str:
    """Return a line for each set-up, the cuts left out, and the simulated residual."""
    lines = []
    for program in run.programs:
        cuts = len(program.setup.cuts)
        tools = ", ".join(f"T{tool.number}" for tool in program.setup.tools)
        plural = "" if cuts == 1 else "s"
        lines.append(
            f"Set-up {program.name}: {program.file}, {cuts} cut{plural}, {tools}, "
            f"{program.time_s / 60.0:.1f} min"
        )
    lines += [f"Not programmed: cut {each.correction}: {each.why}" for each in run.plan.not_programmed]
    worst = run.part.tolerance.worst(run.residual)
    verdict = "within tolerance" if run.used_share <= 1.0 else "ABOVE TOLERANCE"
    lines.append(
        f"Simulated from the text: {sum(run.taken_g.values()):.2f} g removed "
        f"({run.mass_difference_g:+.3f} g compared with the report), "
        f"residual{worst.where} {worst.residual_g_mm:.2f} g·mm of permitted "
        f"{worst.permissible_g_mm:.2f} g·mm ({percent(run.used_share)}): {verdict}"
    )
    lines.append("No move hits; not proven on a machine: run it 100 mm above the part first")
    return "\n".join(lines)


# ``setup.pdf``: clamping, zero, tools and the cuts in their order, for each set-up.


def setup_sheet(run: NcRun) -> bytes:
    """Return the sheet as PDF, a page or more for each set-up."""
    load_reportlab()
    from reportlab.lib.pagesizes import A4
    from reportlab.lib.units import mm
    from reportlab.platypus import PageBreak, SimpleDocTemplate

    stream = io.BytesIO()
    document = SimpleDocTemplate(
        stream,
        pagesize=A4,
        leftMargin=16 * mm,
        rightMargin=16 * mm,
        topMargin=14 * mm,
        bottomMargin=14 * mm,
        title=f"Set-ups for {run.part.name}",
        invariant=1,
    )
    parts: list[Any] = []
    for program in run.programs:
        if parts:
            parts.append(PageBreak())
        parts += _setup_section(run, program)
    if run.plan.not_programmed or not parts:
        parts += _left_out(run)
    document.build(parts)
    return stream.getvalue()


def _styles() -> tuple[Any, Any, Any]:
    from reportlab.lib.styles import ParagraphStyle

    from autobalance.paper.pen import font_of

    plain, bold = font_of("a"), font_of("a", bold=True)
    return (
        ParagraphStyle("h", fontName=bold, fontSize=14, leading=18, spaceAfter=4),
        ParagraphStyle("s", fontName=bold, fontSize=9.5, leading=12, spaceBefore=8, spaceAfter=3),
        ParagraphStyle("p", fontName=plain, fontSize=8.5, leading=11.5),
    )


def _setup_section(run: NcRun, program: Program) -> list[Any]:
    from reportlab.platypus import Paragraph

    head, section, plain = _styles()
    zero, setup = run.zero, program.setup
    axes = {
        "R": "X counts along the axis from zero, Z from the axis, Y = 0 is the axis",
        "T": "X and Y count from the axis, Z from zero upwards",
        "B": "X and Y count from the axis, Z from zero upwards: the crank rests on its +z end",
        "L": "X is the diameter, Z counts along the axis from zero; Z is the middle of the tool's nose",
    }[program.name]
    safe = f"{setup.safe_mm:.4f} mm" + (" (diameter)" if program.name == "L" else "")
    lines = [
        f"Hold: {CLAMPING_TEXTS[program.name]}.",
        f"Zero: {axes}.",
        f"Angle zero is {zero.angle_of} ({zero.angle_deg:.4f}° in the rotor frame); "
        f"z zero is {zero.z_of} (z = {zero.z_mm:.4f} mm).",
        f"Safe height {safe}; tool and holder keep {run.machine.zero.clearance_mm:g} mm from metal in rapid. "
        f"About {program.time_s / 60.0:.1f} min.",
    ]
    if run.machine.zero.finish_mm:
        lines.append(f"{run.machine.zero.finish_mm:g} mm are left on every depth.")
    story: list[Any] = [Paragraph(f"Set-up {program.name}: {program.file}", head)]
    story += [Paragraph(line, plain) for line in lines]
    story.append(Paragraph("Tools", section))
    tools = [
        [
            f"T{tool.number}",
            tool_words(tool),
            f"{tool.flute_mm:g}",
            " + ".join(f"dia {d:g} x {length:g}" for d, length in tool.holder),
        ]
        for tool in setup.tools
    ]
    story.append(_table([["tool", "what", "flutes mm", "holder mm"], *tools], (14, 84, 22, 58)))
    story.append(Paragraph("Cuts, in this order", section))
    rows = [_cut_row(run, cut, tool.number) for cut, tool in setup.cuts]
    what = ["cut", "tool", "what", "at °", "z mm", "depth mm", "takes g"]
    columns = [*what, "0.05 mm", "0.05°", "2° point"]
    story.append(_table([columns, *rows], (9, 10, 42, 15, 17, 17, 16, 17, 17, 18)))
    note = "Last three columns: unbalance from an error of depth, angle or point, in g·mm."
    story += [
        Paragraph(note, plain),
        Paragraph("Before the first part", section),
        Paragraph(
            "1. Set zero and tool lengths. 2. Run the program with zero 100 mm above the part, in single "
            "block, rapid override low. 3. Run it with --finish-mm 0.5 and measure. 4. Then to size. "
            "The program was simulated from its own text on the solid; it is not proven on a machine. "
            "Clamps, centres, chuck and tailstock are not in the simulation.",
            plain,
        ),
    ]
    return story


def _cut_row(run: NcRun, cut: Listed, tool: int) -> list[str]:
    """Return the cells of a cut, the last three effects of small errors of depth, angle and point [g·mm]."""
    item = decoded(Correction, cut.item)
    rate = item.unbalance_per_mm_g_mm
    depth = NO_VALUE if rate is None or rate is ABSENT else f"{0.05 * math.hypot(*rate):.2f}"
    turn = math.radians(0.05) * math.hypot(*item.unbalance_change_g_mm)
    point = NO_VALUE
    operation = cut.operation
    if isinstance(operation, HoleOperation) and operation.point_deg < 180.0:
        radius = 0.5 * operation.diameter_mm
        longer = abs(radius / math.tan(math.radians(0.5 * (operation.point_deg + 2.0))) - operation.point_mm)
        volume = math.pi * radius**2 * longer / 3.0
        point = f"{volume * run.part.density_g_mm3 * item.radius_mm:.2f}"
    named = "" if item.label is ABSENT else item.label.partition(": ")[2]
    label = (named or item.kind).replace("⌀", "dia ")
    return [
        str(cut.number),
        f"T{tool}",
        label if item.web is None else f"{label}, web {item.web}",
        f"{item.angle_deg:.3f}",
        f"{item.z_mm:.3f}",
        f"{abs(item.depth_mm):.3f}",
        f"{run.taken_g.get(cut.number, 0.0):.3f}",
        depth,
        f"{turn:.2f}",
        point,
    ]


def _left_out(run: NcRun) -> list[Any]:
    from reportlab.platypus import Paragraph

    _, section, plain = _styles()
    lines = [f"Cut {each.correction}: {each.why}." for each in run.plan.not_programmed]
    return [Paragraph("Not programmed", section), *(Paragraph(line, plain) for line in lines)]


def _table(rows: list[list[str]], widths: tuple[float, ...]) -> Any:
    from reportlab.lib.colors import toColor
    from reportlab.lib.units import mm
    from reportlab.platypus import Table, TableStyle

    from autobalance.paper.pen import font_of

    table = Table(rows, colWidths=[width * mm for width in widths], repeatRows=1)
    table.setStyle(
        TableStyle(
            [
                ("FONT", (0, 0), (-1, -1), font_of("a"), 7.5),
                ("FONT", (0, 0), (-1, 0), font_of("a", bold=True), 7),
                ("LINEBELOW", (0, 0), (-1, -1), 0.25, toColor("#c9c9c4")),
                ("TOPPADDING", (0, 0), (-1, -1), 2),
                ("BOTTOMPADDING", (0, 0), (-1, -1), 2),
                ("LEFTPADDING", (0, 0), (-1, -1), 2),
                ("RIGHTPADDING", (0, 0), (-1, -1), 2),
            ]
        )
    )
    table.hAlign = "LEFT"
    return table

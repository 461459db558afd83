"""``ab.sheet``: the shop sheet and the drawing again, from a report and the solid beside it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.errors import FormatError
from autobalance.quantities import with_parts
from autobalance.report.files import Staging, refuse_another_run
from autobalance.report.output_kinds import KINDS
from autobalance.report.reportlab_alone import load_reportlab
from autobalance.value_classes import dataclass
from autobalance.verbs.result import Values, VerbResult

if TYPE_CHECKING:
    from autobalance.report.material import Choice
    from autobalance.report.records.answers import SheetReport
    from autobalance.solid.csg.solid import Solid

SHEETS = {name: KINDS[name].files[name] for name in ("pdf", "dxf")}
"""The kinds that a report and its solid are enough for → their files."""


DONE = "done.json"
"""File beside a report with the cuts that are done: number to time, ISO 8601."""


def cuts_done(folder: Path) -> dict[int, str]:
    """Return the cuts of a result that are done: number to time, here and to the minute.

    Raises
    ------
    FormatError
        If the file is not a table of numbers and times.
    """
    path = folder / DONE
    if not path.is_file():
        return {}
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        times = {int(number): datetime.fromisoformat(time) for number, time in told.items()}
    except (AttributeError, TypeError, ValueError):
        raise FormatError(f"{DONE} is invalid; expected the time of each number of a cut") from None
    return {number: time.astimezone().strftime("%m-%d %H:%M") for number, time in sorted(times.items())}


@dataclass(frozen=True, eq=False, repr=False)
class SheetResult(VerbResult):
    """Sheet and drawing as bytes; ``write`` puts them into a folder."""

    content: SheetReport
    made: Mapping[str, bytes]
    source: Path

    def files(self) -> Mapping[str, bytes]:
        """Return ``sheet.pdf`` and ``drawing.dxf``, as far as they were requested."""
        return {self._name(kind): data for kind, data in self.made.items()}

    def _name(self, kind: str) -> str:
        """Return the name of a file; it begins with part and serial where the job has them."""
        return self.content.outputs[kind].file

    def text(self, units: str = "metric") -> str:
        """Return a line: of what the sheet is."""
        del units
        cuts = self.content.corrections
        return f"{self.content.report}: {cuts} cut{'s' * (cuts != 1)} drawn, nothing measured"

    def write(self, folder: str | Path, only: tuple[str, ...] | None = None) -> tuple[Path, ...]:
        """Write the files to a folder, all or none; ``only`` names some of ``pdf``, ``dxf``.

        Raises
        ------
        FileError
            If they cannot be written, or the folder holds another run's report.
        """
        folder = Path(folder)
        refuse_another_run(folder, self.source)
        chosen = {self._name(kind): data for kind, data in self.made.items() if only is None or kind in only}
        with Staging([folder]) as staging:
            for name, data in chosen.items():
                staging.add(folder / name, data)
            staging.commit()
        return tuple(folder / name for name in chosen)


def sheet(
    report: str | Path,
    *,
    only: Sequence[str] = ("pdf",),
    paper: str = "A4",
    units: str | None = None,
    zero: str = "keyway",
    date: str | None = None,
) -> SheetResult:
    """Draw the shop sheet of a report again, on other paper or in other units; nothing is measured.

    Cuts that the app ticked as done, in ``done.json`` beside the report, have their times on it.
    Outlines are those of the corrected solid; the cuts are drawn as the report lists them.

    Parameters
    ----------
    report : path
        Report of balance or recut, its solid beside it.
    only : sequence of str
        Kinds of file to draw, pdf or dxf or both with a comma between. ``dxf`` needs the extra of its name.
    paper : {"A4", "Letter"}
        Paper of sheet.pdf.
    units : {"metric", "inch"} or None
        Units of sheet.pdf, and of the DXF's dimensions, whose coordinates are mm; None: those
        of the shop, else metric.
    zero : {"keyway", "crankpin"}
        Zero of the angles of sheet.pdf; without a keyway it is crankpin 1.
    date : str or None
        Date printed on the sheet; None: today.

    Returns
    -------
    SheetResult

    Raises
    ------
    FileError, FormatError, ClaimError If the report or its solid is missing or invalid, or the solid is
    another.
    """
    from autobalance.report.job_header import file_prefix
    from autobalance.report.records.answers import SheetReport, WrittenFile
    from autobalance.report.records.balanced import BalancedReport
    from autobalance.verification.earlier_stage import earlier_stage

    path = Path(report)
    choice = replace(_choice(only, paper, units or "metric", zero, date), done=cuts_done(path.parent))
    left = earlier_stage(path)
    values: Values = dict(left.values)
    values["reason"] = with_parts(values.get("reason"), values.get("reason_parts"))
    try:
        own = BalancedReport.read(values)
        if units is None:
            choice = replace(choice, units=own.given.shop.units or "metric")
        files = _drawn(values, left.source.solid, left.anatomy.file_to_rotor, choice)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        raise FormatError(
            f"{path.name} cannot be drawn: {type(error).__name__} at {error}; "
            "expected a report as balance writes it"
        ) from None
    prefix = file_prefix(own.given.job, own.serial)
    outputs = {
        kind: WrittenFile(file=prefix + SHEETS[kind], sha256=hashlib.sha256(data).hexdigest())
        for kind, data in files.items()
    }
    report_made = SheetReport(report=path.name, corrections=len(own.corrections), outputs=outputs)
    return SheetResult(report_made, files, path)


def _choice(only: Sequence[str], paper: str, units: str, zero: str, date: str | None) -> Choice:
    from autobalance.report.bundle import choice_of

    for kind in only:
        if kind not in SHEETS:
            raise FormatError(f"only is {kind!r}; expected one of {', '.join(SHEETS)}")
    return choice_of(only, paper, units, date, zero)


def _drawn(values: Values, solid: Solid, frame: Any, choice: Choice) -> dict[str, bytes]:
    load_reportlab()
    from autobalance.paper.drawing import drawn, listed_metal
    from autobalance.report.balance.values import showable
    from autobalance.report.bundle import bundle
    from autobalance.report.material import FileMaterial
    from autobalance.report.records.balanced import BalancedReport

    shown = showable(values)
    report, left = BalancedReport.read(shown), solid.moved(frame)
    outlines = drawn(report, left.mesh, listed_metal(report, left))
    files = bundle(FileMaterial(shown, choice, left, None, (), lambda _: None, outlines))
    return {kind: data for kind, (_, data) in files.items()}

"""Material of the files for people, and the choice among them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from autobalance import registry
from autobalance.runtime import Notify
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.balancing.measured import Crank
    from autobalance.report.page.view import Shown
    from autobalance.report.records.balanced import BalancedReport
    from autobalance.solid.csg.solid import Solid


@dataclass(frozen=True)
class Choice:
    """Chosen kinds of files, paper, units, date on the pages, zero of the angles, and cuts that are done.

    ``done`` has the time of each cut that is done, as it is printed, by its number.
    """

    kinds: Collection[str]
    paper: Any = "A4"
    units: Any = "metric"
    date: str = ""
    zero: Any = "keyway"
    done: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class FileMaterial:
    """Material of the files; shared parts are computed once.

    Attributes
    ----------
    report : mapping
        As written to JSON.
    choice : Choice
    before, after : Solid or None
        File coordinates [mm]; ``after`` None if nothing was cut.
    tools : sequence of Solid
        The tool body of each correction, file coordinates.
    notify : callable
        Called with what runs, in a few words.
    drawn : object or None
        The outlines, where they are there already.
    crank : Crank or None
        As it was measured before it was cut: where it was scanned, its surface is shown.
    """

    report: Mapping[str, Any]
    choice: Choice
    before: Solid
    after: Solid | None
    tools: Sequence[Solid]
    notify: Notify
    drawn: Any = None
    crank: Crank | None = None

    @cached_property
    def balanced(self) -> BalancedReport:
        """The report as a record."""
        from autobalance.report.records.balanced import BalancedReport

        return BalancedReport.read(self.report)

    @cached_property
    def shown(self) -> Shown:
        """The crank in pieces: the body that stays, and the metal of each correction."""
        from autobalance.report.page.view import Shown

        return Shown.of(self.balanced, self.before, self.after, self.tools)

    @cached_property
    def pictures(self) -> tuple[bytes, bytes]:
        """The crank before and after, as PNG."""
        from autobalance.report.pictures.picture import pictures

        shown = self.shown
        self.notify("drawing pictures")
        return pictures(self.balanced, self.before.mesh, shown.body, shown.pieces, units=self.choice.units)

    @cached_property
    def surface(self) -> bytes | None:
        """The surface of a scan in the colours of its distance from its own surfaces or drawing, as PNG."""
        if self.crank is None:
            return None
        from autobalance.report.pictures.picture import surface_image
        from autobalance.report.pictures.zbuffer import png

        image = surface_image(self.crank)
        return None if image is None else png(image)

    @cached_property
    def drawings(self) -> Any:
        """The outlines of the crank and of the removed metal, as the papers draw them."""
        if self.drawn is not None:
            return self.drawn
        pieces = self.shown.pieces
        self.notify("drawing the shop sheet")
        return registry.loaded(registry.DRAWINGS)(self.balanced, self.before, pieces)

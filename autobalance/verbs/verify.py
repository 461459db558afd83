"""``verify``: read a corrected solid from disk again and check every number that its report claims."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from autobalance.value_classes import dataclass
from autobalance.verbs.result import VerbResult
from autobalance.verification.check import check_report
from autobalance.verification.checked import Checked
from autobalance.wording import NOT_PROVEN

if TYPE_CHECKING:
    from autobalance.report.display_units import DisplayUnits
    from autobalance.report.records.answers import VerifyReport
    from autobalance.verification.claims import Claim

ABOVE_TOLERANCE = 4


@dataclass(frozen=True, eq=False, repr=False)
class VerifyResult(VerbResult):
    """A report all of whose claims hold; one whose claims fail raises ``ClaimError``."""

    content: VerifyReport
    checked: Checked

    @property
    def holds(self) -> bool:
        """Whether every claim holds."""
        return self.content.holds

    @property
    def within_tolerance(self) -> bool:
        """Whether the residual, as measured again, is within tolerance."""
        return self.content.within_tolerance

    @property
    def claims(self) -> tuple[Claim, ...]:
        """Checked claims, each with its place, its value, the measured value, and the check."""
        return self.checked.claims

    @property
    def not_checked(self) -> tuple[tuple[str, str], ...]:
        """Keys of the report that nothing in its files decides, and why."""
        return tuple((each.key, each.why) for each in self.checked.not_checked)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Oddities seen beside the claims."""
        return self.checked.warnings

    @property
    def exit_code(self) -> int:
        """0, or 4 above tolerance."""
        return 0 if self.within_tolerance else ABOVE_TOLERANCE

    def text(self, units: str = "metric") -> str:
        """Return the verdict, and the names of what was not checked."""
        keys = ", ".join(each.key for each in self.checked.not_checked)
        return "\n".join(self._lines(units, [f"Not checked: {keys} (--verbose: why)"] if keys else []))

    def full_text(self, units: str = "metric") -> str:
        """Return the verdict, and why something was not checked."""
        why = [f"  {each.key}: {each.why}" for each in self.checked.not_checked]
        return "\n".join(self._lines(units, ["Not checked:", *why] if why else []))

    def _lines(self, units: str, not_checked: list[str]) -> list[str]:
        from autobalance.report.display_units import ON_SCREEN, in_units

        checked, chosen = self.checked, ON_SCREEN[units]
        proven = checked.tolerance.is_proven_by(checked.residual, checked.budget)
        verdict, worst = "within" if checked.within else "ABOVE", checked.tolerance.worst(checked.residual)
        words = (
            f"{self.content.report}: all {len(checked.claims)} claims hold; residual{worst.where} "
            f"{chosen.of_unbalance(worst.residual_g_mm)} of permitted "
            f"{chosen.of_unbalance(worst.permissible_g_mm)}{_doubt(checked, chosen)}: "
            f"{verdict} tolerance{'' if proven or not checked.within else NOT_PROVEN}"
        )
        doubts = checked.tolerance.doubts(checked.residual, checked.budget)
        lines = [words, *(in_units(text, chosen) for text in doubts)]
        if checked.agreement is not None:
            agree = f"volume, first and second moments agree to {checked.agreement:.1e}"
            lines.append(f"Measured a second way, from slices: {agree}")
        return [*lines, *not_checked]


def verify(report: str | Path, *, independent: bool = False) -> VerifyResult:
    """Check every number that a report claims of its corrected solid.

    Parameters
    ----------
    report : path
        Report that balance or recut wrote, beside its solid. Or its folder.
    independent : bool
        Measure the solid from its slices too, a mesh also by trimesh, and require all to agree.

    Raises
    ------
    FileError, FormatError
        If the report or a file cannot be read.
    ClaimError
        If a claim fails.
    """
    from autobalance.report.balance.values import report as as_report
    from autobalance.report.balance.values import schema
    from autobalance.report.records.answers import VerifyReport

    path = Path(report)
    path = path / "report.json" if (path / "report.json").is_file() else path
    checked = check_report(path, independent, as_report, schema())
    values = VerifyReport(
        report=str(path),
        holds=True,
        within_tolerance=checked.within,
        claims=len(checked.claims),
        residual_g_mm=checked.residual.magnitude_g_mm,
        permissible_g_mm=checked.tolerance.permissible_g_mm,
        agreement=checked.agreement,
        not_checked=checked.not_checked,
        warnings=checked.warnings,
    )
    return VerifyResult(values, checked)


def _doubt(checked: Checked, units: DisplayUnits) -> str:
    """Return the uncertainty of the residual in words, where it counts in the verdict."""
    if checked.tolerance.margin == "none" or checked.budget is None:
        return ""
    return f", and its uncertainty of {units.of_unbalance(checked.budget.total_g_mm)} counts"

"""A finite-element analysis in words, tables and plots."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.finite_elements.analysis import Answer, FemMode
from autobalance.finite_elements.answer import FemReport
from autobalance.report.plots import Plot

# The words and tables of a finite-element analysis.


def fem_text(report: FemReport) -> str:
    answer = report.answer
    mesh = answer.mesh
    lines = [
        f"{mesh.tetrahedra} quadratic tetrahedra, {mesh.nodes} nodes, size {mesh.size_mm:.4g} mm; "
        f"volume off by {100.0 * mesh.volume_error:.2g} %",
        "",
        *(_static(answer) if answer.modes is None else _modes(answer.modes)),
        "",
        "mesh size [mm]   nodes   " + ("principal [MPa]" if answer.modes is None else "frequencies [Hz]"),
    ]
    for level in answer.convergence:
        shown = level.frequencies_hz or level.values[:1]
        values = "  ".join(f"{value:.2f}" for value in shown)
        lines.append(f"{level.size_mm:14.4g} {level.nodes:7d}   {values}")
    return "\n".join(lines)


def _modes(modes: Sequence[FemMode]) -> list[str]:
    return ["mode   frequency [Hz]        ±   kind"] + [
        f"{mode.number:4d} {mode.frequency_hz:16.2f} {mode.error_hz:8.2g}   {mode.kind}" for mode in modes
    ]


def _static(answer: Answer) -> list[str]:
    lines = []
    if stress := answer.stress:
        principal, error = stress.greatest_principal_MPa, stress.error_MPa
        at = ", ".join(f"{value:.2f}" for value in stress.at_mm)
        lines += [
            f"largest von Mises stress     {stress.greatest_von_mises_MPa:.2f} MPa at ({at}) mm",
            f"largest principal stress     {principal:.2f} MPa, ± {error:.2g} MPa",
        ]
    if answer.displacement is not None:
        lines.append(f"maximum displacement        {answer.displacement.greatest_mm:.4g} mm")
    if answer.reactions_N is not None:
        reactions = ", ".join(f"{value:.1f}" for value in answer.reactions_N)
        lines.append(f"reactions                    ({reactions}) N")
    return lines


# Convergence of a finite-element analysis from mesh to mesh, as plots.


def fem_plots(report: FemReport) -> dict[str, Plot]:
    """Return a bar chart of the modes' frequencies, or of the stress, for each mesh."""
    from autobalance.report import plots

    modes, levels = report.answer.modes, report.answer.convergence
    if modes is not None:
        places = [f"{mode.number} ({mode.kind})" for mode in modes]
        groups = {f"{level.nodes} nodes": level.values for level in levels}
        drawn = plots.named_bars("Natural frequencies", ("mode", "frequency [Hz]"), places, groups)
        return {"fem-modes": drawn}
    places = [f"{level.nodes} nodes" for level in levels]
    heights = {"maximum principal stress": [level.values[0] for level in levels]}
    return {"fem-stress": plots.named_bars("Maximum stress", ("mesh", "stress [MPa]"), places, heights)}

"""The words and tables of a finite-element analysis."""

from __future__ import annotations

from autobalance.types import Values


def fem_text(values: Values) -> str:
    mesh = values["mesh"]
    lines = [
        f"{mesh['tetrahedra']} quadratic tetrahedra, {mesh['nodes']} nodes, size {mesh['size_mm']:.4g} mm; "
        f"volume off by {100.0 * mesh['volume_error']:.2g} %",
        "",
        *(_modes(values) if values["modes"] is not None else _stress(values)),
        "",
        "mesh size [mm]   nodes   "
        + ("frequencies [Hz]" if values["modes"] is not None else "principal [MPa]"),
    ]
    for level in values["convergence"]:
        results = level.get("frequencies_hz") or [level["greatest_principal_MPa"]]
        lines.append(
            f"{level['size_mm']:14.4g} {level['nodes']:7d}   "
            + "  ".join(f"{value:.2f}" for value in results)
        )
    return "\n".join(lines)


def _modes(values: Values) -> list[str]:
    lines = ["mode   frequency [Hz]        ±   kind"]
    for mode in values["modes"]:
        lines.append(
            f"{mode['number']:4d} {mode['frequency_hz']:16.2f} {mode['error_hz']:8.2g}   {mode['kind']}"
        )
    return lines


def _stress(values: Values) -> list[str]:
    stress, moved = values["stress"], values["displacement"]["greatest_mm"]
    mises, principal = stress["greatest_von_mises_MPa"], stress["greatest_principal_MPa"]
    at = ", ".join(f"{value:.2f}" for value in stress["at_mm"])
    reactions = ", ".join(f"{value:.1f}" for value in values["reactions_N"])
    return [
        f"greatest von Mises stress    {mises:.2f} MPa at ({at}) mm",
        f"greatest principal stress    {principal:.2f} MPa, ± {stress['error_MPa']:.2g} MPa",
        f"greatest displacement        {moved:.4g} mm",
        f"reactions                    ({reactions}) N",
    ]

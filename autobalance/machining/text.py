"""Summary of ``nc`` as lines to read."""

from __future__ import annotations

from autobalance.machining.run import NcRun
from autobalance.wording import percent


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

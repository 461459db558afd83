"""The report of ``nc``, written as ``nc.json``."""

from __future__ import annotations

import hashlib

from autobalance.machining.answer import NcCut, NcReport, NcResidual, NcSetup, Simulated
from autobalance.machining.run import NcRun, Program
from autobalance.report.records.balance import Unbalance


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

"""The report of `generate`, and its text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

from autobalance.declare import ABSENT, Absent, NotNegative, Ordinal, Range, Sha256, present, record
from autobalance.drawn_cranks.design import Design
from autobalance.report.balance.crank_text import anatomy_text, unbalance_text
from autobalance.report.balance.sections_text import suggestions_text
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.balance import Unbalance
from autobalance.report.records.crank import Crank
from autobalance.report.records.source import Frame, Versions
from autobalance.report.records.stage import Suggestions
from autobalance.version import SCHEMA_VERSION

# The report of `generate`.


@record
class DrawnBobWeight:
    """The bob-weight of a throw."""

    throw: Ordinal
    mass_g: NotNegative


@record
class DrawnEngine:
    """Balance factor and bob-weights of the drawn crank with the given parts."""

    balance_factor: float | None
    bob_weights: Sequence[DrawnBobWeight]


@record
class DrawnSolid:
    """The written file."""

    file: str
    sha256: Sha256
    triangles: Annotated[int, Range(least=4)] | None


@record
class DrawnOutputs:
    """The written files."""

    solid: DrawnSolid


@record
class GenerateReport:
    """Report of `generate --json`: dimensions in, mass properties out."""

    SCHEMA_HEAD: ClassVar = {
        "$id": "https://autobalance.invalid/generate-1.schema.json",
        "title": "Report of autobalance generate, schema_version 1",
        "description": "What `autobalance generate --json` writes: the dimensions of the crank that was "
        "built, and its true mass properties; `crank`, `initial` and `frame` are those of "
        "any other report.",
    }
    schema_version: Literal[1] = SCHEMA_VERSION
    autobalance: Versions
    command: Literal["generate"] = "generate"
    design: Design
    frame: Frame
    crank: Crank
    initial: Unbalance
    engine: DrawnEngine | None
    outputs: DrawnOutputs
    suggestions: (
        Annotated[
            Suggestions,
            "only with --suggest: what would give the crank a wanted factor or "
            "inertia, each tried on the solid",
        ]
        | Absent
    ) = ABSENT


# Summary of ``generate``, for people.


def generate_text(report: GenerateReport, units: DisplayUnits) -> str:
    """Return the summary of a generated crank: dimensions in, mass, unbalance and balance factor out."""
    parts = [
        _generated(report, units),
        anatomy_text(report.crank, units),
        unbalance_text(report.initial, units),
    ]
    return "\n\n".join([*parts, *filter(None, [suggestions_text(present(report.suggestions))])])


def _generated(report: GenerateReport, units: DisplayUnits) -> str:
    design, body, solid = report.design, report.crank.body, report.outputs.solid
    centre = ", ".join(units.of_length(value) for value in body.centre_of_mass_mm)
    surface = "exact surfaces" if solid.triangles is None else f"{solid.triangles} triangles"
    weight = design.counterweight
    lines = [
        f"{solid.file}: {design.name}, {surface}",
        f"  stroke {units.of_length(design.stroke_mm)}",
        f"  web {design.web.outline}, {units.of_length(design.web.thickness_mm)} thick",
        "  no counterweights"
        if weight is None
        else f"  counterweight radius {units.of_length(weight.radius_mm)}, {weight.fan_angle_deg:g}°",
        f"  mass {units.of_mass(body.mass_g)}, volume {units.of_volume(body.volume_mm3)}",
        f"  centre of mass {centre} (rotor frame)",
        f"  polar inertia {units.of_inertia(body.polar_inertia_kg_mm2)}",
    ]
    error = report.crank.facet_error
    if error is not None:
        unbalance = units.of_unbalance(error.unbalance_g_mm)
        lines.append(f"  the facets hide {units.of_mass(error.mass_g)} and {unbalance}")
    return "\n".join(lines + _achieved(report.engine, units))


def _achieved(engine: DrawnEngine | None, units: DisplayUnits) -> list[str]:
    if engine is None:
        return []
    if engine.balance_factor is None:
        return ["  no balance factor: the throws cancel each other out"]
    bob = units.of_mass(engine.bob_weights[0].mass_g)
    return [f"  balance factor {100.0 * engine.balance_factor:.2f} %, bob-weight {bob} on throw 1"]

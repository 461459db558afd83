"""Summary of ``generate``, for people."""

from __future__ import annotations

from autobalance.declare import present
from autobalance.drawn_cranks.answer import DrawnEngine, GenerateReport
from autobalance.report.balance.crank_text import anatomy_text, unbalance_text
from autobalance.report.balance.sections_text import suggestions_text
from autobalance.report.display_units import DisplayUnits


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

"""Stress of the webs, before and after, as lines and as rows of the page."""

from __future__ import annotations

from autobalance.crank_dynamics.strength.web_bending import Bending


def bending_text(bending: Bending) -> str:
    """Return stresses of the webs side by side, as lines."""
    rows = [("Bending of the webs", "before", "after"), *bending_rows(bending)]
    wide = [max(len(row[k]) for row in rows) for k in range(3)]
    lines = [
        f"{'' if number == 0 else '  '}{row[0]:<{wide[0] + (2 if number == 0 else 0)}}"
        f"  {row[1]:>{wide[1]}}  {row[2]:>{wide[2]}}"
        for number, row in enumerate(rows)
    ]
    return "\n".join([*lines, *(f"  {line}" for line in bending_words(bending))])


def bending_rows(bending: Bending) -> list[tuple[str, str, str]]:
    """Return (name, stress before, stress after) of each web, and of the throw that was meshed."""
    rows = [
        (f"web {each.web}, weakest section", _mpa(each.before_MPa), _mpa(each.after_MPa))
        for each in bending.webs
    ]
    elements = bending.elements
    if elements is not None and elements.before_MPa is not None and elements.after_MPa is not None:
        stress = _mpa(elements.before_MPa), _mpa(elements.after_MPa)
        rows.append((f"throw {elements.throw}, finite elements", *stress))
    return rows


def bending_words(bending: Bending) -> list[str]:
    """Return the load behind the stresses, and mesh and time of the finite-element analysis."""
    forces = [each for each in bending.force_N if each > 0.0]
    if not bending.webs:
        return ["no throw is alone between two main journals; nothing is computed"]
    load = f"{min(forces, default=0.0) / 1e3:.1f}"
    if forces and max(forces) > 1.001 * min(forces):
        load += f" to {max(forces) / 1e3:.1f}"
    words = [f"nominal, under the inertia of the rods at top dead centre: {load} kN on each crankpin"]
    elements = bending.elements
    if elements is None:
        return words
    if elements.failed is not None:
        words.append(f"no finite elements of throw {elements.throw}: {elements.failed}")
    else:
        words.append(
            "finite elements: stress that 1 % of the throw's surface exceeds; a coarse mesh of "
            f"{elements.nodes} nodes, {elements.seconds:.0f} s; "
            "before and after may differ by 10 % from their meshes alone"
        )
    return words


def _mpa(stress: float) -> str:
    return f"{stress:.2f} MPa"

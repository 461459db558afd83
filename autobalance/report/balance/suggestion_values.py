"""What would give a crank a wanted factor or inertia, as JSON values: mm, degrees, g, kg·mm²."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from autobalance.balancing.suggestions.wanted import Aim, Bore, Refused, Suggestion
from autobalance.rigid_rotor.moments import Moments
from autobalance.units import wrapped_deg

Values = dict[str, Any]
G_MM2_PER_KG_MM2 = 1000.0


def suggestion_values(aim: Aim, found: Sequence[Suggestion], refused: Sequence[Refused]) -> Values:
    """Return what is wanted, what is there, what would do it and what would not."""
    wanted = aim.wanted
    inertia = None if wanted.inertia_g_mm2 is None else wanted.inertia_g_mm2 / G_MM2_PER_KG_MM2
    return {
        "wanted": {"balance_factor": wanted.balance_factor, "inertia_kg_mm2": inertia},
        "now": _state(aim, aim.start),
        "found": [_suggestion(aim, each) for each in found],
        "refused": [{"kind": each.kind, "reason": each.reason} for each in refused],
    }


def _state(aim: Aim, moments: Moments) -> Values:
    return {
        "balance_factor": aim.factor(moments),
        "inertia_kg_mm2": moments.polar_inertia_g_mm2 / G_MM2_PER_KG_MM2,
        "mass_g": moments.mass_g,
        "unbalance_g_mm": [float(each) for each in moments.first_g_mm[:2]],
    }


def _suggestion(aim: Aim, each: Suggestion) -> Values:
    left, wanted = aim.missing(each.tried), aim.wanted
    factor = aim.factor(each.tried)
    short_factor = None if wanted.balance_factor is None or factor is None else wanted.balance_factor - factor
    return {
        "kind": each.kind,
        "text": each.text,
        "reached": aim.reached(each.tried),
        "changes": [
            {"key": one.key, "from": one.before, "closed_form": one.closed_form, "to": one.after}
            for one in each.changes
        ],
        "bores": [_bore(one) for one in each.bores],
        "leaves": {
            **_state(aim, each.tried),
            "short_balance_factor": short_factor,
            "short_inertia_kg_mm2": None
            if left.inertia_g_mm2 is None
            else left.inertia_g_mm2 / G_MM2_PER_KG_MM2,
            "mass_change_g": each.tried.mass_g - aim.start.mass_g,
        },
    }


def _bore(bore: Bore) -> Values:
    return {
        "web": bore.web,
        "diameter_mm": bore.diameter_mm,
        "depth_mm": bore.depth_mm,
        "closed_form_depth_mm": bore.closed_form_mm,
        "radius_mm": bore.radius_mm,
        "angle_deg": wrapped_deg(math.degrees(bore.angle_rad)),
        "z_mm": bore.z_mm,
        "mass_g": bore.mass_g,
    }

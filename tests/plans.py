"""Reports of plans that nobody balanced: random cuts of every kind on a crank of numbers, for paper."""

from __future__ import annotations

import copy
import json
import math
from functools import cache
from typing import Any

import numpy as np

from autobalance.paper.drawing import Drawings, drawn, listed_metal
from autobalance.report.records.balanced import BalancedReport
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from tests.jobs import ROOT

KINDS = ("drill", "slug", "mill", "shoulder", "turn", "add")
MANY = ("drill", "slug", "mill")
FACES_UP_TO = 24
"""Up to which number whole faces and rims are cut, too: a web has few of these."""
STEEL = 7.85e-3
WEBS = ((-44.0, -24.0), (-12.0, 8.0), (20.0, 40.0), (52.0, 72.0))
RIM, HALF_FAN = 48.0, math.radians(75.0)


@cache
def crank() -> Solid:
    """Return a crank's shape: a fan with a hub for each web, a shaft through all."""
    turn = math.pi + np.linspace(-HALF_FAN, HALF_FAN, 61)
    fan = np.concatenate([[[0.0, 0.0]], RIM * np.stack([np.cos(turn), np.sin(turn)], axis=1)])
    hub = Region.circle(24.0, 72, (12.0, 0.0))
    total = Solid.prism(Region.circle(12.0, 72), -60.0, 90.0)
    for low, high in WEBS:
        total = total + Solid.prism(Region.of([fan]) + hub, low, high)
    return total


def plan(count: int, kinds: tuple[str, ...] = KINDS, seed: int = 1) -> dict[str, Any]:
    """Return a report with that many cuts, of these kinds in turn; the rest is of a stored report."""
    rng = np.random.default_rng(seed)
    text = (ROOT / "tests" / "golden" / "straight-factor-0.28.json").read_text("utf-8")
    report: dict[str, Any] = copy.deepcopy(json.loads(text))
    report["autobalance"] = {"version": "0"}
    report["input"]["file"], report["input"]["sha256"] = "crank.stl", "0" * 64
    report["job"]["file"] = "job.toml"
    report["frame"]["file_to_rotor"] = np.eye(4).tolist()
    report["crank"]["webs"] = [
        {"number": k, "z_min_mm": low, "z_max_mm": high, "counterweight": True, "outline": None}
        for k, (low, high) in enumerate(WEBS, 1)
    ]
    report["crank"]["throws"][0]["crank_radius_mm"] = 22.0
    many = tuple(kind for kind in kinds if kind in MANY) or kinds
    report["corrections"] = []
    for number in range(1, count + 1):
        among = kinds if number <= FACES_UP_TO else many
        report["corrections"].append(_cut(number, among[(number - 1) % len(among)], rng))
    return report


def drawings_of(report: dict[str, Any]) -> Drawings:
    """Return the outlines of the crank and of the cuts as listed."""
    solid = crank()
    return drawn(BalancedReport.read(report), solid.mesh, listed_metal(BalancedReport.read(report), solid))


def _cut(number: int, kind: str, rng: np.random.Generator) -> dict[str, Any]:
    web = int(rng.integers(1, len(WEBS) + 1))
    low, high = WEBS[web - 1]
    turn = math.pi + float(rng.uniform(-0.8 * HALF_FAN, 0.8 * HALF_FAN))
    depth, mass = float(rng.uniform(2.0, 12.0)), float(rng.uniform(0.5, 30.0))
    maker = {"drill": _hole, "slug": _slug, "mill": _pocket, "shoulder": _face, "turn": _ring, "add": _face}
    own = maker[kind](turn, depth, (low, high), rng)
    place = np.array(own.pop("place"))
    sign = -1.0 if kind in {"add", "slug"} else 1.0
    radius = float(rng.uniform(20.0, 40.0))
    change = -sign * mass * radius * np.array([math.cos(turn), math.sin(turn)])
    return {
        "kind": kind,
        "number": number,
        "face": f"w{web}-a" if kind in {"shoulder", "add"} else None,
        "web": web,
        "position_mm": place.tolist(),
        "radius_mm": radius if kind in {"drill", "slug"} else math.hypot(*place[:2]),
        "depth_mm": -depth if kind == "add" else depth,
        "removed_mass_g": sign * mass,
        "removed_volume_mm3": sign * mass / STEEL,
        "unbalance_change_g_mm": change.tolist(),
        "unbalance_per_mm_g_mm": (change / depth).tolist(),
        "moment_per_mm_g_mm2": (change / depth * place[2]).tolist(),
        **own,
        "angle_deg": math.degrees(math.atan2(place[1], place[0])) % 360.0,
        "z_mm": float(place[2]),
    }


Web = tuple[float, float]
Own = dict[str, Any]


def _hole(turn: float, depth: float, web: Web, rng: np.random.Generator) -> Own:
    e = np.array([math.cos(turn), math.sin(turn)])
    diameter = float(rng.choice([6.0, 8.0, 10.0, 12.5]))
    if rng.random() < 0.5:
        place = [*(RIM * e), float(rng.uniform(web[0] + 4.0, web[1] - 4.0))]
        inward, direction = [-e[0], -e[1], 0.0], "radial"
    else:
        up = bool(rng.random() < 0.5)
        place = [*(float(rng.uniform(26.0, 42.0)) * e), web[1] if up else web[0]]
        inward, direction = [0.0, 0.0, -1.0 if up else 1.0], "axial"
    return {
        "place": place,
        "direction": direction,
        "diameter_mm": diameter,
        "point_angle_deg": 118.0,
        "point_mm": 0.5 * diameter / math.tan(math.radians(59.0)),
        "deepened_from_mm": None,
        "entry_radius_mm": math.hypot(place[0], place[1]),
        "inward": inward,
        "wall_left_mm": float(rng.uniform(2.0, 5.0)),
        "depth_left_mm": float(rng.uniform(0.0, 5.0)),
    }


def _slug(turn: float, depth: float, web: Web, rng: np.random.Generator) -> Own:
    own = _hole(turn, depth, web, rng)
    del own["point_mm"], own["deepened_from_mm"]
    along = np.array(own["place"]) + 0.75 * depth * np.array(own["inward"])
    return own | {
        "point_angle_deg": 180.0,
        "length_mm": 0.5 * depth,
        "density_kg_m3": 17600.0,
        "slug_mass_g": float(rng.uniform(5.0, 60.0)),
        "slug_centre_mm": along.tolist(),
        "centrifugal_load_N": float(rng.uniform(100.0, 5000.0)),
    }


def _pocket(turn: float, depth: float, web: Web, rng: np.random.Generator) -> Own:
    half = float(rng.uniform(0.1, 0.3))
    up = bool(rng.random() < 0.5)
    face = web[1] if up else web[0]
    return {
        "place": [36.0 * math.cos(turn), 36.0 * math.sin(turn), face + (-0.5 if up else 0.5) * depth],
        "direction": "axial",
        "cutter_mm": 8.0,
        "corner_radius_mm": 4.0,
        "inner_radius_mm": 30.0,
        "outer_radius_mm": 42.0,
        "start_deg": math.degrees(turn - half) % 360.0,
        "end_deg": math.degrees(turn + half) % 360.0,
        "face_z_mm": face,
        "wall_left_mm": float(rng.uniform(2.0, 5.0)),
        "depth_left_mm": float(rng.uniform(0.0, 5.0)),
    }


def _face(_turn: float, depth: float, web: Web, _rng: np.random.Generator) -> Own:
    return {
        "place": [-30.0, 1.0, web[1] - 0.5 * depth],
        "normal": [0.0, 0.0, 1.0],
        "face_height_mm": web[1] + depth,
        "new_height_mm": web[1],
        "area_mm2": 100.0,
    }


def _ring(_turn: float, depth: float, web: Web, _rng: np.random.Generator) -> Own:
    return {
        "place": [-40.0, 0.0, 0.5 * (web[0] + web[1])],
        "rim_radius_mm": RIM,
        "new_radius_mm": RIM - min(depth, 4.0),
        "depth_left_mm": 1.0,
    }

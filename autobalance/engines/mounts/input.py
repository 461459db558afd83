"""The tables [mounts] and [[mount]] of a job: the engine as a rigid body and its mounts."""

from __future__ import annotations

import numpy as np

from autobalance.declare import COUNTED, NOT_NEGATIVE, POSITIVE, Key, Values
from autobalance.engines.mounts.model import Mounts
from autobalance.engines.mounts.rigid_body import Mount, MountedEngine
from autobalance.errors import JobError
from autobalance.job.addon_tables import AddonTables, TablesRead
from autobalance.units import G_MM2_PER_KG_MM2, RAD_S_PER_RPM

Vector = tuple[float, float, float]
G_PER_KG = 1e3
G_S2_PER_N_MM = 1e6
"""Stiffness: 1 N/mm in g/s²."""

MOUNT = Key(
    "mount",
    says="a mount",
    keys=(
        Key("at_mm", Vector, "point of the engine that it holds"),
        Key("k_N_mm", Vector, "stiffness along x, y, z", NOT_NEGATIVE),
        Key(
            "damping_ratio",
            float,
            "share of critical damping",
            NOT_NEGATIVE,
            None,
            usual="`mounts.damping_ratio`",
        ),
    ),
    many=True,
    default=(),
    verbs="forces",
)
POINT = (
    Key("name", str, "description: a handlebar, a seat"),
    Key("at_mm", Vector, "position of the point"),
)
MOUNTS = Key(
    "mounts",
    says="the engine on its mounts; places in the rotor's frame at crank angle 0, origin on the crank axis",
    default=None,
    verbs="forces",
    keys=(
        Key("mass_kg", float, "mass of the engine with all parts on it", POSITIVE),
        Key("centre_mm", Vector, "its centre of mass"),
        Key("inertia_kg_mm2", tuple[Vector, Vector, Vector], "inertia about that centre, 3 × 3"),
        Key("damping_ratio", float, "damping ratio of mounts without their own", NOT_NEGATIVE, 0.05),
        Key("speed_rpm", tuple[float, float], "lowest and highest speed looked at", POSITIVE, None,
            usual="600 to `balance.speed_rpm`"),
        Key("points", int, "speeds looked at", COUNTED, 60),
        Key("point", says="a place whose motion is reported", keys=POINT, many=True, default=()),
        MOUNT,
    ),
)  # fmt: skip


def _made(read: TablesRead) -> Mounts | None:
    values = read.values
    if not values.get("mounts") and not values.get("mount"):
        return None
    top = values["balance"]["speed_rpm"] * RAD_S_PER_RPM
    return mounts_of(values.get("mounts"), values.get("mount") or [], top)


TABLES = AddonTables((MOUNTS, MOUNT), _made, needs=("balance",))


def mounts_of(values: Values | None, listed: list[Values], top_rad_s: float) -> Mounts | None:
    """Return the engine on its mounts; None if the job has no mounts.

    Raises
    ------
    JobError If the inertia is missing, or nothing holds the engine.
    """
    if values is None:
        if listed:
            raise JobError("[[mount]] is given; expected [mounts] with the engine's mass beside it")
        return None
    inertia = np.array(values["inertia_kg_mm2"]) * G_MM2_PER_KG_MM2
    if not np.allclose(inertia, inertia.T) or not (np.linalg.eigvalsh(inertia) > 0.0).all():
        raise JobError("mounts.inertia_kg_mm2 is not an inertia; expected a symmetric, positive 3 × 3")
    entries = [*values["mount"], *listed]
    if not entries:
        raise JobError("[[mounts.mount]] is missing; expected at least one")
    usual = values["damping_ratio"]
    mounts = tuple(
        Mount(
            np.array(each["at_mm"]),
            np.array(each["k_N_mm"]) * G_S2_PER_N_MM,
            usual if each["damping_ratio"] is None else each["damping_ratio"],
        )
        for each in entries
    )
    engine = MountedEngine(values["mass_kg"] * G_PER_KG, np.array(values["centre_mm"]), inertia, mounts)
    low, high = values["speed_rpm"] or (600.0, top_rad_s / RAD_S_PER_RPM)
    if not low < high:
        raise JobError(f"mounts.speed_rpm is [{low:g}, {high:g}]; the first must be the lower one")
    points = tuple((each["name"], np.array(each["at_mm"])) for each in values["point"])
    return Mounts(engine, np.linspace(low, high, values["points"]) * RAD_S_PER_RPM, points)

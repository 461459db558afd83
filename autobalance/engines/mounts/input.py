"""The tables [mounts] and [[mount]] of a job: the engine as a rigid body and its mounts."""

from __future__ import annotations

from typing import Literal

import numpy as np

from autobalance.declare import COUNTED, NOT_NEGATIVE, POSITIVE, Key, Values
from autobalance.engines.mounts.rigid_body import Mount, MountedEngine
from autobalance.engines.mounts.spectra import FrameFile, MeasuredSpectrum, Mounts
from autobalance.errors import JobError
from autobalance.job.tables import AddonTables, TablesRead
from autobalance.types import Array
from autobalance.units import G_MM2_PER_KG_MM2, G_PER_KG, G_S2_PER_N_MM, RAD_S_PER_RPM

Axis = Literal["x", "y", "z"]
Body = Literal["engine", "frame"]
Unit = Literal["m", "mm"]
Vector = tuple[float, float, float]
G_S_PER_N_S_MM = 1e6
"""Damping: 1 N·s/mm in g/s."""

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
        Key(
            "loss_factor",
            float,
            "k (1 + iη) in place of a damping ratio ζ, η = 2ζ",
            NOT_NEGATIVE,
            None,
            usual="2 ζ",
        ),
        Key(
            "loss_factor_by_hz",
            tuple[tuple[float, float], ...],
            "pairs of frequency [Hz] and loss factor, straight between",
            NOT_NEGATIVE,
            None,
            usual="`loss_factor`",
        ),
        Key("c_N_s_mm", Vector, "damper beside the spring along x, y, z", NOT_NEGATIVE, None, usual="none"),
    ),
    many=True,
    default=(),
    verbs="forces",
)
POINT = (
    Key("name", str, "description: a handlebar, a seat"),
    Key("at_mm", Vector, "position of the point"),
    Key("on", Body, "body that it is fixed to", default="engine"),
)
FRAME = (
    Key("file", str, "modes of the frame, relative to the job: CSV, or a universal file with dataset 55"),
    Key(
        "unit",
        Unit,
        "unit of length of a universal file without dataset 164; mass is kg with m, t with mm",
        default="m",
    ),
    Key("damping_ratio", float, "damping ratio of modes without one in the file", NOT_NEGATIVE, 0.02),
    Key("within_mm", float, "largest distance from a mount or point to its node", POSITIVE, 5.0),
)
MEASURED = (
    Key("point", str, "name of a `[[mounts.point]]`"),
    Key("axis", Axis, "direction of the sensor"),
    Key("file", str, "report of `orders --json` of its record, relative to the job"),
)
MOUNTS = Key(
    "mounts",
    says="the engine on its mounts; places in the rotor's frame at crank angle 0, origin on the crank axis",
    default=None,
    verbs="forces",
    keys=(
        Key("mass_kg", float, "mass of the engine with all parts on it", POSITIVE),
        Key("centre_mm", Vector, "centre of mass"),
        Key("inertia_kg_mm2", tuple[Vector, Vector, Vector], "inertia about that centre, 3 × 3"),
        Key("damping_ratio", float, "damping ratio of mounts without their own", NOT_NEGATIVE, 0.05),
        Key("speed_rpm", tuple[float, float], "lowest and highest speed looked at", POSITIVE, None,
            usual="600 to `balance.speed_rpm`"),
        Key("points", int, "speeds looked at", COUNTED, 60),
        Key("point", says="a place whose motion is reported", keys=POINT, many=True, default=()),
        Key("frame", says="a flexible frame below the mounts", keys=FRAME, default=None),
        Key("measured", says="orders measured at a point", keys=MEASURED, many=True, default=()),
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
            _damping(each, usual),
            _loss(each),
            None if each["c_N_s_mm"] is None else np.array(each["c_N_s_mm"]) * G_S_PER_N_S_MM,
        )
        for each in entries
    )
    engine = MountedEngine(values["mass_kg"] * G_PER_KG, np.array(values["centre_mm"]), inertia, mounts)
    low, high = values["speed_rpm"] or (600.0, top_rad_s / RAD_S_PER_RPM)
    if not low < high:
        raise JobError(f"mounts.speed_rpm is [{low:g}, {high:g}]; the first must be the lower one")
    points = tuple((each["name"], np.array(each["at_mm"])) for each in values["point"])
    measured = tuple(MeasuredSpectrum(**each) for each in values["measured"])
    names = [name for name, _ in points]
    for place, each in enumerate(measured, 1):
        if each.point not in names:
            raise JobError(
                f"mounts.measured[{place}].point is {each.point!r}; must be a [[mounts.point]]:"
                f" {', '.join(names) or 'none'}"
            )
    on_frame = tuple(each["name"] for each in values["point"] if each["on"] == "frame")
    if on_frame and values["frame"] is None:
        raise JobError(
            f"mounts.point {on_frame[0]!r} is on the frame; [mounts.frame] with its modes is missing"
        )
    frame = None if values["frame"] is None else FrameFile(**values["frame"])
    speeds = np.linspace(low, high, values["points"]) * RAD_S_PER_RPM
    return Mounts(engine, speeds, points, measured, frame, on_frame)


def _damping(mount: Values, usual: float) -> float:
    if mount["loss_factor"] is not None:
        if mount["damping_ratio"] is not None:
            raise JobError("mount.loss_factor is given beside damping_ratio; must be one or the other")
        return float(mount["loss_factor"]) / 2.0
    return usual if mount["damping_ratio"] is None else float(mount["damping_ratio"])


def _loss(mount: Values) -> Array | None:
    pairs = mount["loss_factor_by_hz"]
    if pairs is None:
        return None
    table = np.array(pairs, dtype=np.float64)
    if not len(table) or (np.diff(table[:, 0]) <= 0.0).any():
        raise JobError("mount.loss_factor_by_hz must have rising frequencies")
    by_rad_s: Array = table * np.array([2.0 * np.pi, 1.0])
    return by_rad_s

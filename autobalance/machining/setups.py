"""Clamping of a crank: set-ups, their axes on the rotor, and the machine's zero."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.errors import JobError
from autobalance.machining.input import MachineTool
from autobalance.types import Array

SetupName = Literal["R", "T", "B", "L"]
CLAMPING_TEXTS = {
    "R": "along the machine's X between centres, on the rotary axis, rotor +z = machine +X; spindle along Z",
    "T": "upright, rotor +z up along machine Z, machine X towards the angle zero",
    "B": "turned over about machine X, rotor -z up along machine Z, machine X towards the angle zero",
    "L": "in the lathe, rotor +z = machine Z, diameter programming",
}


@dataclass(frozen=True)
class NcZero:
    """The machine's zero in the rotor frame, and in words the datum that is touched for it."""

    angle_deg: float
    z_mm: float
    angle_of: str
    z_of: str


def zero_of(machine: MachineTool, anatomy: Anatomy) -> NcZero:
    """Return the zero that a machine's file asks for on a crank.

    Raises
    ------
    JobError
        If the crank has not what it names.
    """
    angle, angle_of = _angle(machine.zero.angle, anatomy)
    z, z_of = _place(machine.zero.z_mm, anatomy)
    return NcZero(angle, z, angle_of, z_of)


def _crankpin(name: str, anatomy: Anatomy) -> int | None:
    words = name.lower().split()
    if len(words) == 2 and words[0] == "crankpin" and words[1].isdecimal():
        return next((k for k, throw in enumerate(anatomy.throws) if throw.number == int(words[1])), None)
    return None


def _angle(stated: float | str, anatomy: Anatomy) -> tuple[float, str]:
    if not isinstance(stated, str):
        return float(stated), f"{stated:g} deg from crankpin 1"
    throw = _crankpin(stated, anatomy)
    if throw is not None:
        x, y = anatomy.throws[throw].direction
        return math.degrees(math.atan2(float(y), float(x))), f"crankpin {anatomy.throws[throw].number}"
    datums = anatomy.datums
    if stated.lower() == "keyway" and datums is not None and datums.keyways:
        longest = max(datums.keyways, key=lambda key: round(key.z_max_mm - key.z_min_mm, 3))
        return longest.angle_deg, "the keyway's middle"
    if stated.lower() == "keyway":
        raise JobError(
            'zero.angle is "keyway"; no keyway was found on this crank; expected "crankpin 1" or degrees'
        )
    raise JobError(f'zero.angle is "{stated}"; expected "crankpin 1", "keyway" or degrees')


def _place(stated: float | str, anatomy: Anatomy) -> tuple[float, str]:
    if not isinstance(stated, str):
        return float(stated), f"z = {stated:g} mm from the middle of crankpin 1"
    throw = _crankpin(stated, anatomy)
    if throw is not None:
        pin = anatomy.throws[throw]
        return float(pin.crankpin.centre_mm[2]), f"the middle of crankpin {pin.number}"
    faces = () if anatomy.datums is None else anatomy.datums.faces
    if stated == "F":
        if faces:
            return faces[0].z_mm, f"face F, the {faces[0].name}"
        web = min(anatomy.webs, key=lambda each: each.z_min_mm)
        return web.z_min_mm, f"face F, the -z face of web {web.number}"
    named = next((face for face in faces if face.name == stated), None)
    if named is not None:
        return named.z_mm, f"the {named.name}"
    known = ", ".join(f'"{face.name}"' for face in faces)
    raise JobError(
        f'zero.z_mm is "{stated}"; expected "crankpin 1", "F", mm' + (f", or one of {known}" if known else "")
    )


def placement(setup: SetupName, zero: NcZero, rotary_sign: int = 1, rotary_deg: float = 0.0) -> Array:
    """Return the motion (4, 4) from a set-up's machine coordinates to the rotor frame.

    In L the machine's X is a radius here, towards the angle zero.
    """
    turn = math.radians(zero.angle_deg + (rotary_sign * rotary_deg if setup == "R" else 0.0))
    out, across = (
        np.array([math.cos(turn), math.sin(turn), 0.0]),
        np.array([-math.sin(turn), math.cos(turn), 0.0]),
    )
    along = np.array([0.0, 0.0, 1.0])
    axes = {
        "R": (along, -across, out),
        "T": (out, across, along),
        "B": (out, -across, -along),
        "L": (out, across, along),
    }[setup]
    frame = np.eye(4)
    frame[:3, :3] = np.stack(axes, axis=1)
    frame[2, 3] = zero.z_mm
    return frame


def inverse(motion: Array) -> Array:
    """Return the inverse of a rigid motion (4, 4)."""
    back = np.eye(4)
    back[:3, :3] = motion[:3, :3].T
    back[:3, 3] = -motion[:3, :3].T @ motion[:3, 3]
    return back


def rotary_deg(angle_deg: float, zero: NcZero, sign: int) -> float:
    """Return the word in [0, 360) that brings an angle of the rotor under the spindle, to 4 decimals."""
    return round(sign * (angle_deg - zero.angle_deg) % 360.0, 4) % 360.0

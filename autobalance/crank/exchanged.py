"""A crank of one throw with main journal and crankpin in each other's place."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalance.crank.anatomy import Anatomy, MainJournal, Pin, Throw


def exchanged(anatomy: Anatomy) -> Anatomy:
    """Return the anatomy about the line of throw 1's crankpin, its main journal 1 being the crankpin.

    Its axis points as before. Webs keep their counterweights, cylinders and doubts are left out: it is for a
    verdict on the other reading of a doubt about the axis.

    Raises
    ------
    ValueError
        If there is not one throw.
    """
    if len(anatomy.throws) != 1:
        raise ValueError(f"{len(anatomy.throws)} throws; main journal and crankpin are exchanged with one")
    pin, journal = anatomy.throws[0].crankpin, anatomy.main_journals[0]
    arm = journal.centre_mm[:2] - pin.centre_mm[:2]
    radius = math.hypot(*arm)
    x, y = arm / radius
    turn = np.eye(4)
    turn[:2, :2] = [[x, y], [-y, x]]
    turn[:3, 3] = -turn[:3, :3] @ np.array([*pin.centre_mm[:2], journal.centre_mm[2]])
    up = float(turn[2, 3])

    def moved(one: Pin) -> np.ndarray:
        return turn[:3, :3] @ one.centre_mm + turn[:3, 3]

    return replace(
        anatomy,
        file_to_rotor=turn @ anatomy.file_to_rotor,
        main_journals=(MainJournal(moved(pin), pin.diameter_mm, pin.width_mm, 1),),
        throws=(Throw(1, radius, 0.0, Pin(moved(journal), journal.diameter_mm, journal.width_mm)),),
        webs=tuple(
            replace(web, z_min_mm=web.z_min_mm + up, z_max_mm=web.z_max_mm + up) for web in anatomy.webs
        ),
        cylinders=(),
        doubts=(),
    )

"""Rotor that is balanced: the crank as a solid, its moments, and the loads that turn with it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from autobalance.correction.contract import Correction, EarlierCut
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.uncertainty import Budget
from autobalance.solid.csg.solid import Solid
from autobalance.types import Floats

if TYPE_CHECKING:
    from autobalance.solid.cad.step import Exact


@dataclass(frozen=True, eq=False)
class Rotor:
    """Rotor that is balanced: the crank in file coordinates [mm] and the loads that turn with it.

    ``exact`` is the crank with its true surfaces, if its file keeps them: plans are made on ``solid``, its
    triangles, and the exact solid is cut. ``moments`` are the bare crank's and ``loads`` those of bob-weights
    and attached rotors, both in the rotor frame. ``loads_per_factor`` is the derivative of the loads with the
    balance factor ``factor``. ``budget`` gives the residual's uncertainty, from the bare crank's moments, the
    corrections made on it and the solid left; None if that is unknown. ``hidden`` gives the moments between
    the facets (loose triangles, file coordinates) and the smooth surface, which ``moments`` include; None:
    nothing is added. ``added`` is the share of a calibration or a scan in them, cut or not. ``earlier`` are
    the cuts of earlier stages, which count if cuts are limited in number.
    """

    solid: Solid
    moments: Moments
    density_g_mm3: float
    anatomy: Anatomy
    faces: tuple[Face, ...]
    loads: Moments
    loads_per_factor: Moments
    factor: float
    budget: Callable[[Moments, Sequence[Correction], Solid | None], Budget] | None = None
    exact: Exact | None = None
    hidden: Callable[[Floats], Moments] | None = None
    earlier: tuple[EarlierCut, ...] = ()
    added: Moments = field(default_factory=Moments.zero)

    def doubt(
        self, bare: Moments, corrections: Sequence[Correction] = (), left: Solid | None = None
    ) -> Budget | None:
        """Return the uncertainty of the residual of the solid ``left``, None where that is not known."""
        return None if self.budget is None else self.budget(bare, corrections, left)

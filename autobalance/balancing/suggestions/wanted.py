"""Wanted balance factor or inertia of a crank, and the distance of its moments from them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Annotated, Any

import numpy as np

from autobalance.balancing.rotor_from_job import beside_throws, crank_factor, throw_loads
from autobalance.crank.anatomy import Anatomy, Web
from autobalance.crank.sections import away_from_crankpin
from autobalance.declare import Angle, Named, NotNegative, Ordinal, Positive
from autobalance.declare.schema import open_keys
from autobalance.errors import JobError
from autobalance.job.model import EngineParts
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.running_gear.parts import LEAST_DIRECTION, ThrowLoad, factor_direction_g_mm
from autobalance.types import Array
from autobalance.units import G_MM2_PER_KG_MM2
from autobalance.value_classes import dataclass

MIN_COSINE = 0.5
"""A web counts towards the factor where its crankpin's direction has this cosine with the factor's."""
NEAR_FACTOR, NEAR_INERTIA = 1e-4, 1e-5
"""Precision of trials: of a factor, and as a share of an inertia."""
REACHED_PRECISION_RATIO = 10.0
"""Multiple of the trials' precision that still counts as reached: sizes are rounded to what can be made."""
KEYS = ("balance_factor", "inertia_kg_mm2")


@dataclass(frozen=True)
class Wanted:
    """A balance factor, an inertia about the crank axis, or both; None: not requested."""

    balance_factor: float | None = None
    inertia_g_mm2: float | None = None

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Wanted:
        """Read ``{"balance_factor": 0.5, "inertia_kg_mm2": 2900}``, either or both.

        Raises
        ------
        JobError
            For other keys, none, or impossible values.
        """
        for key, value in values.items():
            if key not in KEYS:
                raise JobError(f"suggest has no {key!r}; it has {' and '.join(KEYS)}")
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not (number and math.isfinite(value) and value >= 0.0):
                raise JobError(f"suggest.{key} is {value!r}; must be a number ≥ 0")
        if not values:
            raise JobError(f"suggest: expected a target: {' or '.join(KEYS)}")
        factor, inertia = values.get("balance_factor"), values.get("inertia_kg_mm2")
        if factor is not None and factor > 1.0:
            raise JobError(f"suggest.balance_factor is {factor:g}; must be 0 to 1")
        if inertia == 0.0:
            raise JobError("suggest.inertia_kg_mm2 is 0; must be > 0")
        return cls(
            None if factor is None else float(factor),
            None if inertia is None else float(inertia) * G_MM2_PER_KG_MM2,
        )


@dataclass(frozen=True)
class Missing:
    """Missing product opposite to the throws [g·mm], and missing inertia [g·mm²] or None."""

    product_g_mm: float
    inertia_g_mm2: float | None


@dataclass(frozen=True, eq=False)
class Aim:
    """A crank as it is, and its wanted factor or inertia.

    Attributes
    ----------
    wanted : Wanted
    start : Moments
        Of the crank, rotor frame.
    anatomy : Anatomy
    loads : tuple of ThrowLoad
        Parts on the throws; empty if no weights are known.
    attached : Moments
        Of attached rotors.
    direction : (2,) float or None
        Unit vector along which unbalance changes the factor; None where the throws cancel each other out.
    per_factor_g_mm : float
        Product that a factor of one takes; 0 without reciprocating mass.
    """

    wanted: Wanted
    start: Moments
    anatomy: Anatomy
    loads: tuple[ThrowLoad, ...]
    attached: Moments
    direction: Array | None
    per_factor_g_mm: float

    @classmethod
    def of(cls, target: Wanted, start: Moments, anatomy: Anatomy, engine: EngineParts | None) -> Aim:
        """Return the aim for a crank with an engine's weights, if any are known.

        Raises
        ------
        JobError If a factor is requested for a crank that has no factor.
        """
        loads = () if engine is None else throw_loads(anatomy, engine)
        attached = Moments.zero() if engine is None else beside_throws(engine)
        factor = None if engine is None else crank_factor(start, loads, attached)
        if target.balance_factor is not None and engine is None:
            raise JobError("suggest.balance_factor needs the weights on the throws, [engine]")
        if target.balance_factor is not None and factor is None:
            raise JobError(
                "suggest.balance_factor: the throws cancel each other out, so the crank has no balance factor"
            )
        if factor is not None:
            along = factor_direction_g_mm(loads)
        else:
            along = sum((throw.direction for throw in anatomy.throws), np.zeros(2))
            if float(np.linalg.norm(along)) < LEAST_DIRECTION * len(anatomy.throws):
                return cls(target, start, anatomy, loads, attached, None, 0.0)
        size = float(np.linalg.norm(along))
        return cls(target, start, anatomy, loads, attached, along / size, 0.0 if factor is None else size)

    def factor(self, moments: Moments) -> float | None:
        """Return the balance factor of a crank with these moments; None if it has no factor."""
        return crank_factor(moments, self.loads, self.attached) if self.loads else None

    def product_g_mm(self, unbalance_g_mm: Array) -> float:
        """Return the part of an unbalance (2,) that lies opposite to the throws."""
        return 0.0 if self.direction is None else -float(unbalance_g_mm @ self.direction)

    def along(self, units: Iterable[Array]) -> float:
        """Return the sum of the components of unit vectors (2,) along the direction."""
        return 0.0 if self.direction is None else float(sum(unit @ self.direction for unit in units))

    def missing(self, moments: Moments) -> Missing:
        """Return the product and inertia that moments lack; a factor that is not wanted is kept."""
        factor = None if self.wanted.balance_factor is None else self.factor(moments)
        if factor is not None and self.wanted.balance_factor is not None:
            product = (self.wanted.balance_factor - factor) * self.per_factor_g_mm
        else:
            product = self.product_g_mm(self.start.first_g_mm[:2] - moments.first_g_mm[:2])
        target = self.wanted.inertia_g_mm2
        return Missing(product, None if target is None else target - moments.polar_inertia_g_mm2)

    def reached(self, moments: Moments, slack: float = REACHED_PRECISION_RATIO) -> bool:
        """Return whether moments are near the wanted ones; ``slack`` 1: within the trials' precision."""
        missing = self.missing(moments)
        scale = self.per_factor_g_mm or float(np.linalg.norm(self.start.first_g_mm[:2])) or 1.0
        inertia = missing.inertia_g_mm2 or 0.0
        return (
            abs(missing.product_g_mm) <= slack * NEAR_FACTOR * scale
            and abs(inertia) <= slack * NEAR_INERTIA * self.start.polar_inertia_g_mm2
        )

    def counterweights(self) -> list[tuple[Web, Array]]:
        """Return the webs with counterweights, each with the unit vector (2,) to its crankpin."""
        webs = [web for web in self.anatomy.webs if web.counterweight]
        return [(web, -away_from_crankpin(web, self.anatomy)) for web in webs]

    def webs(self) -> list[tuple[Web, Array]]:
        """Return the webs with counterweights that count towards the factor; all if no web has one."""
        webs = self.counterweights()
        if self.direction is None:
            return webs
        return [(web, towards) for web, towards in webs if float(towards @ self.direction) > MIN_COSINE]


@open_keys
@dataclass(frozen=True)
class SuggestedChange:
    """A size of a design that changes, by its dotted key: as it was, by the closed form, and as tried."""

    key: str
    before: Annotated[float, Named("from")]
    closed_form: float
    after: Annotated[float, Named("to")]


@open_keys
@dataclass(frozen=True)
class SuggestedBore:
    """A bore for heavy metal, flat-bottomed along the crank axis, from a web's face away from its pin on.

    ``mass_g`` is the mass that it removes, or adds if filled. ``radius_mm`` and ``angle_deg`` are its place,
    ``z_mm`` its beginning. ``closed_form_depth_mm`` is the depth before it was tried.
    """

    web: Ordinal
    diameter_mm: Positive
    depth_mm: NotNegative
    closed_form_depth_mm: float
    radius_mm: NotNegative
    angle_deg: Angle
    z_mm: float
    mass_g: float


@dataclass(frozen=True, eq=False)
class Suggestion:
    """A change that reaches the aim, and the crank's moments with it, measured on the solid."""

    kind: str
    text: str
    tried: Moments
    changes: tuple[SuggestedChange, ...] = ()
    bores: tuple[SuggestedBore, ...] = ()


@dataclass(frozen=True)
class Refused:
    """A change that does not reach the aim, and the reason."""

    kind: str
    reason: str

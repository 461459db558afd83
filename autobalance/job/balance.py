"""The table [balance] of a job: requirements on the balanced crank."""

from __future__ import annotations

import math
from typing import Literal

from autobalance.declare import ANY, FILLED, NOT_NEGATIVE, POSITIVE, SHARE, Key, Values
from autobalance.errors import JobError
from autobalance.job.model import Attached, Balance, External, ExternalPart
from autobalance.rigid_rotor.margin import Margin
from autobalance.rigid_rotor.tolerance import Judge
from autobalance.units import RAD_S_PER_RPM

COUNTERWEIGHT_DEG = 180.0
"""Default angle of overbalance: opposite to crankpin 1."""
EXTERNAL_PART = (
    Key("name", str, "name of the place"),
    Key("z_mm", float, "position along the axis, rotor frame"),
    Key(
        "unbalance_g_mm", tuple[float, float], "unbalance it carries now [x, y], rotor frame", ANY, (0.0, 0.0)
    ),
    Key("max_g_mm", float, "largest unbalance that it can carry", POSITIVE, None, usual="any"),
    Key("angle_deg", float, "only angle at which it can carry it", ANY, None, usual="anywhere"),
)
BALANCE = Key(
    "balance",
    says="target of the balanced crank",
    default=FILLED,
    verbs="all",
    keys=(
        Key(
            "factor",
            float | Literal["original"],
            'share of the reciprocating mass to balance, 0 to 1, or `"original"`',
            SHARE,
            typed="share",
        ),
        Key(
            "grade",
            float,
            "balance quality grade G; crank drives of single-cylinder engines are listed at G 250 to G 630, "
            "racing "
            "practice uses G 6.3 on the crankshaft itself",
            POSITIVE,
            typed="mm/s",
        ),
        Key("speed_rpm", float, "maximum service speed", POSITIVE),
        Key(
            "judge",
            Judge,
            '`"dynamic"`: the resultant and each tolerance plane; `"static"`: the resultant alone',
            default="dynamic",
        ),
        Key(
            "margin",
            Margin,
            '`"expanded"`: the verdict needs the residual and its uncertainty together within the '
            "permissible unbalance",
            default="none",
        ),
        Key(
            "facet_correction",
            bool,
            "`true`: the metal between the mesh's facets and the smooth surface is estimated and added to "
            "all results; declined, with the reason, if that may not improve the results",
            default=False,
        ),
        Key(
            "rotor_mass_g",
            float,
            "mass of the rotor: crank before correction and all crankpins not in the file, no bob-weights",
            POSITIVE,
            None,
            usual="measured",
        ),
        Key(
            "tolerance_planes_mm",
            tuple[float, float],
            "z of both tolerance planes in the rotor frame, the lower one first",
            ANY,
            None,
            usual="mid-planes of the outermost main journals",
        ),
        Key(
            "overbalance_g_mm",
            float,
            "unbalance left on purpose for the last holes on the machine",
            NOT_NEGATIVE,
            0.0,
        ),
        Key("overbalance_deg", float, "angle of that unbalance", ANY, COUNTERWEIGHT_DEG),
        Key(
            "external",
            External,
            'unbalance of the external parts: `"solve"`: the value that needs no cut; `"neutral"`: zero; '
            '`"detroit"`: the value that they have now',
            ANY,
            "none",
        ),
        Key(
            "external_part",
            says="a damper, flexplate or flywheel that carries unbalance; one or two",
            keys=EXTERNAL_PART,
            many=True,
            default=(),
        ),
    ),
)


def balance_of(values: Values) -> Balance:
    """Return the requirements of ``[balance]``.

    Raises
    ------
    JobError
        If they contradict each other.
    """
    planes = values["tolerance_planes_mm"]
    if planes is not None and not planes[0] < planes[1]:
        raise JobError(
            f"balance.tolerance_planes_mm is [{planes[0]:g}, {planes[1]:g}]; the first must be the lower one"
        )
    return Balance(
        None if values["factor"] == "original" else values["factor"],
        values["grade"],
        values["speed_rpm"] * RAD_S_PER_RPM,
        values["judge"],
        values["rotor_mass_g"],
        planes,
        values["overbalance_g_mm"],
        math.radians(values["overbalance_deg"]),
        values["margin"],
        values["facet_correction"],
        values["external"],
        _external_parts(values),
    )


def fitted_parts(balance: Balance) -> tuple[Attached, ...]:
    """Return the external parts that count as they are, "detroit", as attached rotors."""
    if balance.external != "detroit":
        return ()
    return tuple(Attached(part.name, 0.0, part.unbalance_g_mm, part.z_mm) for part in balance.external_parts)


def _external_parts(values: Values) -> tuple[ExternalPart, ...]:
    parts = values["external_part"]
    if bool(parts) != (values["external"] != "none") or len(parts) > 2:
        raise JobError(
            f'balance.external is "{values["external"]}" with {len(parts)} [[balance.external_part]];'
            " expected one or two parts, and none without it"
        )
    if len({each["name"] for each in parts}) < len(parts):
        raise JobError(
            f"balance.external_part has two parts named {parts[0]['name']!r}; expected a name for each"
        )
    return tuple(
        ExternalPart(
            each["name"],
            each["z_mm"],
            each["unbalance_g_mm"],
            each["max_g_mm"],
            None if each["angle_deg"] is None else math.radians(each["angle_deg"]),
        )
        for each in parts
    )

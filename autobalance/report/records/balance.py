"""What a report says of unbalance, tolerance, cuts and written solids."""

from typing import Annotated, Any, Literal, NotRequired, TypedDict

from autobalance.records import Angle, Bound, NotNegative, Ordinal, Pair, Positive, Sha256, Share, Triple
from autobalance.report.records.crank import MassProperties
from autobalance.report.records.schema import open_keys


class CounterweightProduct(TypedDict):
    """m_cw·r′ before, wanted, after."""

    initial: float
    target: float
    final: float


class Counterweight(TypedDict):
    """Mass, radius and product of a single-throw crank's counterweights."""

    mass_g: Positive
    radius_mm: float
    product_g_mm: CounterweightProduct


class BobWeight(TypedDict):
    """What stands in for a throw's rods and pistons."""

    throw: Ordinal
    mass_g: NotNegative
    fit_g: Annotated[
        float, "to clamp on where the crank is spun: a crankpin that is not in the file is fitted then"
    ]
    tolerance_g: Annotated[
        NotNegative, "all bob-weights off by it at once use a tenth of the permissible value"
    ]


class Engine(TypedDict):
    """Sums of the parts, and the bob-weights."""

    rotating_g: NotNegative
    reciprocating_g: NotNegative
    crankpin_g: NotNegative
    bob_weights: list[BobWeight]


class BalanceFactor(TypedDict):
    """Before, wanted, after; null where the crank has none."""

    initial: float | None
    target: Share
    final: float | None


class TolerancePlane(TypedDict):
    """A tolerance plane and its share."""

    name: Literal["A", "B"]
    z_mm: float
    permissible_g_mm: Positive


class Tolerance(TypedDict):
    """What ISO 21940-11 permits."""

    grade_mm_s: Positive
    speed_rpm: Positive
    rotor_mass_g: Positive
    permissible_g_mm: Positive
    planes: Annotated[list[TolerancePlane], Bound("maxItems", 2)]
    judge: Literal["dynamic", "static"]
    margin: NotRequired[Literal["none", "expanded"]]


class Plane(TypedDict):
    """Unbalance in a tolerance plane."""

    name: Literal["A", "B"]
    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    uncertainty_g_mm: NotRequired[NotNegative | None]
    uncertainty_shares_g_mm: NotRequired[dict[str, NotNegative] | None]


class Unbalance(TypedDict):
    """Unbalance as judged: bob-weights and attached parts included."""

    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    angle_deg: Angle
    planes: Annotated[list[Plane], Bound("maxItems", 2)]
    moment_g_mm2: Pair
    uncertainty_g_mm: NotNegative | None
    uncertainty_shares_g_mm: dict[str, NotNegative] | None
    uncertainty_unstated: NotRequired[list[str] | None]


@open_keys
class Correction(TypedDict):
    """A cut, or metal that was added; a kind adds what it takes to make it."""

    kind: str
    number: Ordinal
    label: NotRequired[Annotated[str, "short name of the cut, for lists and trees"]]
    tool_volume_mm3: NotRequired[Annotated[NotNegative, "of the tool's body, air included"]]
    file_position_mm: NotRequired[Annotated[Triple, "position_mm in file coordinates"]]
    file_axis: NotRequired[
        Annotated[
            Triple | None,
            "unit vector in file coordinates: into the metal for holes, pockets and lowered faces, "
            "+z of the rotor for rims, outward for added metal",
        ]
    ]
    face: str | None
    web: Ordinal | None
    position_mm: Annotated[
        Triple, "entry on the tool's axis for drill and slug, else the centre of what goes or comes"
    ]
    radius_mm: NotNegative
    depth_mm: Annotated[
        float, "drill and slug: from the entry to the end of the full diameter; below 0 where metal comes"
    ]
    removed_mass_g: float
    removed_volume_mm3: float
    unbalance_change_g_mm: Pair
    unbalance_per_mm_g_mm: NotRequired[Pair | None]
    moment_per_mm_g_mm2: NotRequired[Pair | None]
    angle_deg: Annotated[Angle, "of position_mm, counter-clockwise seen from +z"]
    z_mm: Annotated[float, "of position_mm"]
    entry_radius_mm: NotRequired[Annotated[NotNegative, "of position_mm: drill and slug"]]
    inward: NotRequired[Annotated[Triple, "unit vector of the feed: drill and slug"]]
    diameter_mm: NotRequired[Positive]
    point_angle_deg: NotRequired[Annotated[float, "180: flat"]]
    face_z_mm: NotRequired[Annotated[float, "where the depth of a milled pocket begins"]]
    entry_lift_mm: NotRequired[
        Annotated[NotNegative, "how far outside the entry the tool begins: drill, slug"]
    ]
    entry_mm: NotRequired[Annotated[Triple | None, "entry of the first stage of a hole that is deepened"]]
    point_mm: NotRequired[Annotated[NotNegative, "length of the point: drill and slug"]]
    side: NotRequired[
        Annotated[Literal[1, -1, None], "the side that the cutter comes from, +z or -z: mill, shoulder, add"]
    ]
    z_from_mm: NotRequired[Annotated[float, "ends of the turned stretch, beyond the web's faces: turn"]]
    z_to_mm: NotRequired[float]
    outline: NotRequired[
        Annotated[
            list[list[dict[str, Any]]],
            "of the area at the new height, x and y of the rotor frame: loops of line [[x, y], [x, y]] and "
            "arc {centre, radius_mm, from_deg, to_deg}, each outer one before its islands: shoulder, add",
        ]
    ]
    outline_to_rotor: NotRequired[
        Annotated[
            list[list[float]], "4x4: from the axes of an outline on a face that is not square to the axis"
        ]
    ]


class Step(TypedDict):
    """A pass: predicted and measured."""

    step: Ordinal
    depths_mm: list[NotNegative]
    predicted_g_mm: NotNegative
    measured_g_mm: NotNegative


class Solid(MassProperties):
    """A written solid and what is claimed of it, rotor frame."""

    file: str
    sha256: Sha256
    triangles: Annotated[Ordinal | None, "null where the file keeps true surfaces"]


class Page(TypedDict):
    """A written file for people."""

    file: str
    sha256: Sha256


@open_keys
class Outputs(TypedDict):
    """Written files by kind."""

    solid: NotRequired[Solid | None]
    solid_holds_slugs: NotRequired[Annotated[bool, "false: there are slugs, and the solid lacks them"]]
    html: NotRequired[Page]
    pdf: NotRequired[Page]
    xlsx: NotRequired[Page]
    png_before: NotRequired[Page]
    png_after: NotRequired[Page]
    dxf: NotRequired[Page]
    tools: NotRequired[Page]
    history: NotRequired[Annotated[Page, "of all stages: recut"]]


class Overbalance(TypedDict):
    """Unbalance left on purpose, and the last holes that would use it up."""

    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    angle_deg: Angle
    last_holes: list[Correction]
    predicted_g_mm: NotNegative | None
    reason: str | None


class JobChange(TypedDict):
    """A key of the job that a relaxation changes."""

    key: Annotated[str, "dotted, as --set takes it"]
    present: Annotated[Any, "null: the job has no such table"]
    proposed: Any
    unit: str | None


class Relaxation(TypedDict):
    """Changes of the job that together make the tolerance reachable."""

    text: str
    changes: list[JobChange]
    used_share: Annotated[NotNegative, "worst judged value left then, over what is permitted there"]
    metal_g: Annotated[NotNegative | None, "metal that it takes then; null: the cuts stay as they are"]
    tried: Annotated[bool, "planned anew with the changes; false: follows from what is left"]

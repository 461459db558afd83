"""What a report says of the crank as measured and recognised."""

from typing import Annotated, Literal, NotRequired, TypedDict

from autobalance.records import Angle, Bound, Matrix3, NotNegative, Ordinal, Pair, Positive, Sha256, Triple


class Versions(TypedDict):
    """The program and the libraries that made the report."""

    version: str
    numpy: str | None
    scipy: str | None
    trimesh: str | None
    manifold3d: str | None


class Input(TypedDict):
    """The crank file."""

    file: Annotated[str | None, "null: made in memory"]
    sha256: Sha256
    format: str | None
    triangles: Ordinal
    bodies: Ordinal
    repairs: list[str]


class Frame(TypedDict):
    """From file coordinates in mm to the rotor frame."""

    file_to_rotor: Annotated[
        list[Annotated[list[float], Bound("minItems", 4), Bound("maxItems", 4)]],
        Bound("minItems", 4),
        Bound("maxItems", 4),
    ]


class Journal(TypedDict):
    """A main journal; of a scanned one also standard errors (``pm``), and how it stands off the fit."""

    number: Ordinal
    centre_mm: Triple
    diameter_mm: Positive
    width_mm: NotNegative
    diameter_pm_mm: NotRequired[NotNegative]
    rms_mm: NotRequired[NotNegative]
    out_of_round_mm: NotRequired[NotNegative]
    journal_run_out_mm: NotRequired[Annotated[NotNegative, "as a dial reads it: twice the distance"]]


class Pin(TypedDict):
    """A crankpin; of a scanned one also what a journal has."""

    centre_mm: Triple
    diameter_mm: Positive
    width_mm: NotNegative
    diameter_pm_mm: NotRequired[NotNegative]
    rms_mm: NotRequired[NotNegative]
    out_of_round_mm: NotRequired[NotNegative]


class Throw(TypedDict):
    """A throw."""

    number: Ordinal
    crank_radius_mm: Positive
    angle_deg: Angle
    crankpin: Pin
    crank_radius_pm_mm: NotRequired[NotNegative]
    angle_pm_deg: NotRequired[NotNegative]


class WebOutline(TypedDict):
    """What a counterweight looks like along the axis."""

    rim_radius_mm: Positive
    fan_angle_deg: Annotated[float, Bound("minimum", 0), Bound("maximum", 360)]
    thickness_mm: Positive
    skew_deg: NotRequired[Annotated[float, Bound("minimum", -90), Bound("maximum", 90)]]


class Web(TypedDict):
    """A web."""

    number: Ordinal
    z_min_mm: float
    z_max_mm: float
    counterweight: bool
    outline: NotRequired[WebOutline | None]


class HiddenMetal(TypedDict):
    """Metal between facets and true surfaces."""

    mass_g: float
    unbalance_g_mm: Pair
    moment_g_mm2: Pair
    polar_inertia_kg_mm2: float


class HiddenMetalAdded(TypedDict):
    """What was added for it before and after the cut."""

    before: HiddenMetal
    after: HiddenMetal


class TooCoarse(TypedDict):
    """How much finer the mesh would have to be."""

    finer: NotNegative
    needed_sag_mm: NotNegative
    text: str


class FacetError(TypedDict):
    """What facets miss of the true surfaces, and how well that is known."""

    mass_g: float
    unbalance_g_mm: float
    mass_bar_g: NotNegative
    unbalance_bar_g_mm: NotNegative
    sag_mm: NotNegative
    correction: Literal["applied", "mass_only", "declined", "not_needed", None]
    reason: str | None
    added: HiddenMetalAdded | None
    too_coarse: TooCoarse | None


class MassProperties(TypedDict):
    """Mass, volume, centre and inertia of a body in the rotor frame."""

    mass_g: Positive
    volume_mm3: Positive
    centre_of_mass_mm: Triple
    inertia_kg_mm2: Matrix3
    polar_inertia_kg_mm2: Positive


class Keyway(TypedDict):
    """A slot along a shaft at an end of the crank; depth from the shaft's surface above it."""

    end: Literal["-z", "+z"]
    angle_deg: Angle
    width_mm: Positive
    depth_mm: Positive
    shaft_diameter_mm: Positive
    z_min_mm: float
    z_max_mm: float


class FlangeHole(TypedDict):
    """A hole of a bolt circle."""

    angle_deg: Angle
    radius_mm: Positive
    diameter_mm: Positive


class Flange(TypedDict):
    """A disc at an end of the crank, its outer face (null: not plane) and its bolt circle."""

    end: Literal["-z", "+z"]
    diameter_mm: Positive
    face_z_mm: float | None
    holes: list[FlangeHole]


class DatumAngle(TypedDict):
    """What angles are measured from besides crankpin 1, and where it stands."""

    of: Literal["keyway", "flange_hole"]
    angle_deg: Angle


class DatumFace(TypedDict):
    """A plane face square to the axis, from which z is measured."""

    of: Literal["flange", "web", "end"]
    name: str
    z_mm: float


class Datums(TypedDict):
    """What can be touched to set the crank up, faces the best first; null or empty where there is none."""

    keyways: list[Keyway]
    flanges: list[Flange]
    angle: DatumAngle | None
    faces: list[DatumFace]


class AxisUncertainty(TypedDict):
    """Standard errors of a scanned crank's axis: amid the main journals, and of its direction."""

    offset_mm: NotNegative
    angle_deg: NotNegative


class Calibration(TypedDict):
    """What a scale and a micrometer say of the scan; of "none" nothing was calibrated by it."""

    by: Literal["skin", "density", "none"]
    skin_mm: Annotated[float, "how far the scanned surface lies outside the crank's"]
    skin_pm_mm: NotNegative
    scale: Annotated[Positive, "of the scan: its lengths over the crank's"]
    scale_pm: NotNegative
    density_kg_m3: Positive
    mass_difference_g: Annotated[float | None, "of the scan as it came less the scale's; null: not weighed"]
    contradictions: list[str]


class Crank(MassProperties):
    """The crank as measured and recognised; of a scanned one also how rough it is, and how sure."""

    main_journals: list[Journal]
    throws: Annotated[list[Throw], Bound("minItems", 1)]
    webs: list[Web]
    journal_misalignment_mm: NotNegative
    facet_error: FacetError | None
    datums: Datums | None
    roughness_mm: NotRequired[Annotated[NotNegative, "root mean square"]]
    axis_uncertainty: NotRequired[AxisUncertainty]
    calibration: NotRequired[Calibration]

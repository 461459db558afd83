"""A crank as it was measured: its solid, anatomy and moments, and its file's bytes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from autobalance.balancing.facet_correction import NOT_ASKED, FacetCorrection
from autobalance.balancing.scan_calibration import Calibration
from autobalance.balancing.scan_uncertainty import Patches, ScanUncertainty, mass_pm_g, scan_uncertainty
from autobalance.balancing.typed_effects import odd_size, typed_warnings
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.crank.recognition.alignment import (
    anatomy_warnings,
    misalignment_warning,
    ovality_warning,
    step_warnings,
)
from autobalance.crank.recognition.candidates import digits_warning
from autobalance.errors import FormatError
from autobalance.job import Job
from autobalance.rigid_rotor.unbalance import Moments, Places, Share, facets_beside_skin, root_sum
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.format import Format
from autobalance.solid.formats.read import Source
from autobalance.solid.formats.registry import format_named, name_of_ending
from autobalance.solid.formats.write import encode
from autobalance.solid.slicing.slices import cross_sections
from autobalance.types import Floats
from autobalance.units import MM_PER
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.crank.against import Against


# A crank as it was measured: its solid, what was recognised in it, and its moments.


MIN_FILLED_SHARE = 0.05
"""Share of the square around a crankpin that even a hollow one fills."""


@dataclass(frozen=True, eq=False)
class ScannedBeside:
    """The scan of a crank whose drawing is cut.

    ``crank`` is the scan as measured, in the rotor frame of the CAD model. ``added`` is the difference of the
    scan's moments from the model's own. ``against`` is the comparison of both surfaces.
    """

    file: Path | None
    crank: Crank
    added: Moments
    against: Against


@dataclass(frozen=True, eq=False)
class Crank:
    """A crank file, read, recognised and measured (moments in the rotor frame).

    With a scan ``beside`` it moments, facets and calibration are the scan's, all else is its own.
    ``scan_accuracy_mm`` is the scanner's (95 %), as stated.
    """

    source: Source
    anatomy: Anatomy
    density_g_mm3: float
    moments: Moments
    facets: ChordalError | None
    correction: FacetCorrection = NOT_ASKED
    faces: tuple[Face, ...] = ()
    calibration: Calibration | None = None
    beside: ScannedBeside | None = None
    scan_accuracy_mm: float | None = None

    @property
    def weighed(self) -> Crank:
        """The crank whose file moments and their uncertainty come from: the scan if there is one."""
        return self if self.beside is None else self.beside.crank

    @property
    def volume_mm3(self) -> float:
        """Volume [mm³], what the facets hide added where the moments have it."""
        added = Moments.zero() if self.facets is None else self.correction.part(self.facets.missing)
        return self.source.volume_mm3 + (added + self.calibrated).mass_g / self.density_g_mm3

    @property
    def calibrated(self) -> Moments:
        """Moments added by a calibration or a scan; zero without."""
        if self.beside is not None:
            return self.beside.added
        return Moments.zero() if self.calibration is None else self.calibration.added

    @property
    def is_calibrated(self) -> bool:
        """Whether its moments were made to agree with what was measured of it."""
        return self.calibration is not None and self.calibration.by != "none"

    @property
    def hidden(self) -> Callable[[Floats], Moments] | None:
        """Estimator of a cut crank's metal beside its loose triangles; None: nothing is added to them."""
        if self.beside is not None:  # the scan's facets, which the drawing's cuts leave alone
            part = Moments.zero() if self.facets is None else self.correction.part(self.facets.missing)
            whole = self.calibrated + part
            return lambda _: whole
        own = None if self.facets is None else self.correction.left(self.facets, self.anatomy)
        if self.calibration is None or not self.is_calibrated:
            return own
        even = self.calibration.added
        return lambda soup: even if own is None else even + own(soup)

    @property
    def patch_moments(self) -> tuple[Moments, ...]:
        """Metal in doubt at each hole that was closed, rotor frame."""
        frame, density = self.anatomy.file_to_rotor, self.density_g_mm3
        return tuple(
            Moments.point(density * patch.volume_pm_mm3, patch.centre_mm).moved(frame)
            for patch in self.source.patches
        )

    @cached_property
    def patches(self) -> Patches:
        """The surface as patches, rotor frame."""
        return Patches.of(self.source.solid.mesh.moved(self.anatomy.file_to_rotor))

    @cached_property
    def mass_pm_g(self) -> float | None:
        """Uncertainty of a scan's mass (95 %) [g]; None where the crank was drawn.

        A thin skin lacks metal as facets do: both add up if nothing was measured of it. Density is not in
        it; nor is what a cut crank's scan, whose noise is not known any more, leaves open.
        """
        crank = self.weighed
        fit = crank.anatomy.scan
        if fit is None or not fit.noise:
            return None
        if crank.calibration is not None and crank.is_calibrated:
            return crank.calibration.mass_pm_g
        density = crank.density_g_mm3
        scan = mass_pm_g(crank.patches, fit, crank.moments.mass_g, density, crank.scan_accuracy_mm)
        closed = math.hypot(*(off.mass_g for off in crank.patch_moments))
        if crank.facets is None:
            return math.hypot(scan, closed)
        bar, lacking = crank.facets.mass_bar_g, crank.facets.missing.mass_g
        if not crank.correction.mass:
            bar = facets_beside_skin(Share(bar + abs(lacking)), Share(scan)).resultant_g_mm
        return math.hypot(scan, bar, closed)

    @property
    def repairs(self) -> tuple[str, ...]:
        """Repairs of the mesh, one line each, with the unbalance that each may cost."""
        patched = (
            f"{patch.text}; the unbalance may be off by {np.hypot(*off.first_g_mm[:2]):.2g} g·mm for it"
            for patch, off in zip(self.source.patches, self.patch_moments, strict=True)
        )
        return (*self.source.repairs, *patched)

    @property
    def holds_crankpins(self) -> bool:
        """Whether the file holds the crankpins, not only bores for them: metal midway along the first."""
        return holds_crankpins(self.anatomy, self.source.solid)

    def warnings(self, file: Path | None, job: Job | None = None) -> tuple[str, ...]:
        """Return warnings of the file and the crank in it, one line each.

        With a job, what was typed of the axis and journals is weighed by its bob-weights and tolerance.
        """
        misaligned = misalignment_warning(self.anatomy)
        oval = ovality_warning(self.anatomy, self.source.solid.mesh)
        digits = None if self.source.exact is not None else digits_warning(self.source.solid.mesh)
        odd = (odd_size(self.source), digits, misaligned, oval)
        read = () if self.calibration is None else self.calibration.contradictions
        texts = [
            *self.repairs,
            *(text for text in odd if text is not None),
            *step_warnings(self.anatomy),
            *anatomy_warnings(self.anatomy),
            *typed_warnings(self.anatomy, self.moments, job),
            *(() if self.anatomy.scan is None else self.anatomy.scan.cautions),
            *read,
        ]
        own = tuple(text if file is None else f"{file}: {text}" for text in texts)
        return own if self.beside is None else (*own, *self.beside.crank.warnings(self.beside.file))


def holds_crankpins(anatomy: Anatomy, solid: Solid) -> bool:
    """Return whether a solid (file coordinates) has metal midway along its first crankpin.

    Told from its section there: a boolean would build the body, a second for a million triangles.
    """
    pin, placed = anatomy.throws[0].crankpin, solid.mesh.moved(anatomy.file_to_rotor)
    (outlines,) = cross_sections(placed.vertices, placed.triangles, pin.centre_mm[2:])
    half = 0.5 * pin.diameter_mm
    x, y, _ = pin.centre_mm
    place = Region.rectangle((x - half, y - half), (x + half, y + half))
    return (Region.of(outlines) & place).area_mm2 > MIN_FILLED_SHARE * place.area_mm2


# Share of a scan in the error budget.


@dataclass(frozen=True, eq=False)
class ScanShare:
    """Uncertainty of a scan, ``None`` where the crank is drawn, and of its closed holes.

    ``off_faces_mm``: distance within which 95 % of its surface lies off the drawing whose faces are cut.
    """

    scan: ScanUncertainty | None
    patched: tuple[Share, ...]
    places: Places
    off_faces_mm: float = 0.0

    def after(self, rates: Sequence[Moments]) -> Share:
        """Return the share after cuts with these changes per millimetre of depth."""
        shares = [*self.patched, *(() if self.scan is None else (self.scan.after(rates),))]
        shares += [Share.of(rate.scaled(self.off_faces_mm), self.places) for rate in rates]
        return root_sum(shares, self.places)


def scan_share(crank: Crank, accuracy_mm: float | None, places: Places) -> ScanShare | None:
    """Return the uncertainty of the unbalance by a scan and closed holes; None if there is neither."""
    off_faces_mm = 0.0 if crank.beside is None else crank.beside.against.p95_mm
    crank = crank.weighed
    patched = tuple(Share.of(off, places) for off in crank.patch_moments)
    if crank.anatomy.scan is None:
        return ScanShare(None, patched, places, off_faces_mm) if patched or off_faces_mm else None
    calibration = crank.calibration
    uncertainty = scan_uncertainty(
        crank.patches,
        crank.anatomy.scan,
        crank.moments,
        crank.density_g_mm3,
        accuracy_mm,
        places,
        None if calibration is None or calibration.by != "skin" else calibration.covariance,
    )
    return ScanShare(uncertainty, patched, places, off_faces_mm)


# A crank's solid as the bytes of a file of any format that can hold it.


def encoded(source: Source, ending: str, unit: str | None = None) -> bytes:
    """Return a solid as the bytes of a file.

    Parameters
    ----------
    source : Source
    ending : str
        Of the file, ``.3mf`` say.
    unit : str or None
        mm, cm, m or inch; None: that of the source, or what the format prescribes.

    Raises
    ------
    FormatError If the format or the unit is unknown, or the format keeps true surfaces and the source has
    triangles.
    """
    name = name_of_ending(ending.lower().lstrip("."))
    kind = format_named(name)
    if unit is not None and unit not in MM_PER:
        raise FormatError(f"the unit '{unit}' is not known; expected one of {', '.join(MM_PER)}")
    if kind.exact:
        if source.exact is None:
            raise FormatError(f"a mesh cannot be saved as {ending}; choose .stl, .obj, .ply or .3mf")
        return source.exact.solid.step(unit or source.exact.unit, source.exact.name)
    return encode(source.solid.mesh, name, _mm_per_unit(kind, unit, source.mm_per_unit))


def _mm_per_unit(kind: Format, unit: str | None, own: float) -> float:
    if kind.mm_per_unit is not None:
        if unit is not None and MM_PER[unit] != kind.mm_per_unit:
            its = next(name for name, mm in MM_PER.items() if mm == kind.mm_per_unit)
            raise FormatError(f"{kind.name.upper()} is in {its}, the unit given is {unit}; leave it out")
        return kind.mm_per_unit
    return own if unit is None else MM_PER[unit]

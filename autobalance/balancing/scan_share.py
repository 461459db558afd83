"""Share of a scan in the error budget."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from autobalance.balancing.measured import Crank
from autobalance.balancing.scan_uncertainty import ScanUncertainty, scan_uncertainty
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.uncertainty import Places, Share, root_sum


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

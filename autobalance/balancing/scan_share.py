"""The share that a scan has in the error budget."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from autobalance.machine_models.measured import Crank
from autobalance.machine_models.scan_uncertainty import ScanUncertainty, scan_uncertainty
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.uncertainty import Places, Share, root_sum


@dataclass(frozen=True, eq=False)
class ScanShare:
    """What a scan leaves uncertain, ``None`` where the crank is drawn, and its closed holes."""

    scan: ScanUncertainty | None
    patched: tuple[Share, ...]
    places: Places

    def after(self, rates: Sequence[Moments]) -> Share:
        """Return the share once cuts are made that change so much with a millimetre of depth."""
        shares = [*self.patched, *(() if self.scan is None else (self.scan.after(rates),))]
        return root_sum(shares, self.places)


def scan_share(crank: Crank, accuracy_mm: float | None, places: Places) -> ScanShare | None:
    """Return what a scan and its closed holes leave uncertain of the unbalance; None where it is drawn."""
    patched = tuple(Share.of(off, places) for off in crank.patch_moments)
    if crank.anatomy.scan is None:
        return ScanShare(None, patched, places) if patched else None
    calibration = crank.calibration
    uncertainty = scan_uncertainty(
        crank.source.solid.mesh,
        crank.anatomy,
        crank.anatomy.scan,
        crank.moments,
        crank.density_g_mm3,
        accuracy_mm,
        places,
        None if calibration is None or calibration.by != "skin" else calibration.covariance,
    )
    return ScanShare(uncertainty, patched, places)

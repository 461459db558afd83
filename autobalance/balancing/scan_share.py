"""The share that a scan has in the error budget."""

from __future__ import annotations

from autobalance.machine_models.measured import Crank
from autobalance.machine_models.scan_uncertainty import scan_uncertainty
from autobalance.rigid_rotor.uncertainty import Places, Share, root_sum


def scan_share(crank: Crank, accuracy_mm: float | None, places: Places) -> Share | None:
    """Return what a scan and its closed holes leave uncertain of the unbalance; None where it is drawn."""
    patched = [Share.of(off, places) for off in crank.patch_moments]
    if crank.anatomy.scan is None:
        return root_sum(patched, places) if patched else None
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
    return root_sum([uncertainty.share, *patched], places)

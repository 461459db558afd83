"""``ab.bearing``: friction, film, stiffness and damping of a bearing, and its film through a cycle."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.declare import MM
from autobalance.report.plots import Plots
from autobalance.value_classes import dataclass
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.engines.bearings.analysis import BearingAnalysis
    from autobalance.engines.bearings.report import BearingReport


@dataclass(frozen=True, eq=False, repr=False)
class BearingResult(VerbResult):
    """A bearing's friction and film."""

    content: BearingReport
    analysis: BearingAnalysis

    def text(self, units: str = "metric") -> str:
        """Return the result as lines for people; always metric."""
        from autobalance.engines.bearings.report import bearing_text

        return bearing_text(self.content)

    def plots(self) -> Plots:
        """Return the film's pressure, its orbit and the moment over the speed, as far as there are any."""
        from autobalance.engines.bearings.report import bearing_plots

        return Plots(bearing_plots(self.analysis))

    def __repr__(self) -> str:
        found = self.content
        shown: dict[str, object] = {"kind": found.kind, "moment_N_m": found.friction.moment_N_m}
        if found.film is not None and found.film.least_film_m is not None:
            shown["eccentricity_ratio"] = found.film.eccentricity_ratio
            shown["least_film_mm"] = MM.written(found.film.least_film_m)
        words = (f"{key}={_short(value)}" for key, value in shown.items() if value is not None)
        return f"<autobalance bearing: {', '.join(words)}>"

    def rotor_bearing(self, z_mm: float, load_deg: float = 270.0) -> dict[str, Any]:
        """Return the film as a ``[[bearing]]`` of ``ab.rotor``, over the speeds if there are several.

        Parameters
        ----------
        z_mm : float
            Its place on the shaft [mm].
        load_deg : float
            Direction of the load on the journal in the rotor's axes, from x to y; 270 is down [°].

        Raises
        ------
        JobError
            If there is no film, or it breaks at one of the speeds.
        """
        from autobalance.engines.bearings.report import rotor_bearing

        return rotor_bearing(self.analysis, z_mm, load_deg)

    def series(self) -> bytes | None:
        """Return the orbit by angle as CSV; None without a history of loads."""
        from autobalance.engines.bearings.report import orbit_series

        return orbit_series(self.analysis)

    def files(self) -> Mapping[str, bytes]:
        """Return the series of the orbit."""
        series = self.series()
        return {} if series is None else {"orbit.csv": series}


def _short(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def bearing(
    bearing: str | Path | Mapping[str, Any], *, history: str | Path | Mapping[str, Any] | None = None
) -> BearingResult:
    """Find friction and film of a bearing.

    Parameters
    ----------
    bearing : path or dict
        Bearing file: its kind and dimensions, and its loads by angle if any. Or its tables; files are
        relative to it, or to the working folder.
    history : path or dict, optional
        Forces of the journal on the bush through a cycle, for the film's orbit, in place of the file's own
        ``file``. Either a CSV file whose columns ``[history]`` names (default: ``x_N`` and ``y_N``), or
        arrays ``angle_deg``, ``x_N`` and ``y_N``, each (n,).

    Returns
    -------
    BearingResult
        ``report`` is what ``autobalance bearing --json`` writes.

    Raises
    ------
    FileError
        If a file cannot be read.
    JobError
        If something in it is unknown, missing, of the wrong type or impossible.

    Examples
    --------
    >>> dry = bearing({"kind": "dry", "diameter_mm": 20.0, "load_N": 25.01, "mu": 0.1})
    >>> round(dry.report["friction"]["moment_N_m"], 6)
    0.024886
    """
    from autobalance.engines.bearings.analysis import analyse
    from autobalance.engines.bearings.input import load_bearing, parse_bearing
    from autobalance.engines.bearings.report import BearingReport

    if isinstance(bearing, Mapping):
        file = parse_bearing(bearing, history=history)
    else:
        file = load_bearing(bearing, history)
    analysis = analyse(file.case, file.speeds_rad_s)
    return BearingResult(BearingReport.of(file.kind, file.described, analysis), analysis)

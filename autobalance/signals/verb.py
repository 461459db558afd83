"""``ab.orders``: spectrum, orders, natural frequencies and sources of a recorded signal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.errors import FormatError, file_errors, refuse_pipe
from autobalance.report.plots import Plots
from autobalance.runtime import no_progress
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import documented
from autobalance.verbs.result import Values, VerbResult

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from autobalance.balancing.measured import Crank
    from autobalance.job import Job
    from autobalance.runtime import Progress
    from autobalance.signals.analysis import AnalysisOptions, SignalAnalysis
    from autobalance.signals.answer import OrdersReport
    from autobalance.signals.record import Channel, SignalRecord
    from autobalance.signals.sources import BearingSource, DriveSources, OrderSource
    from autobalance.signals.spectra import Quantity

BEARING_KEYS = ("balls", "ball", "pitch", "contact", "speed")


@dataclass(frozen=True, eq=False, repr=False)
class OrdersResult(VerbResult):
    """Orders, levels and sources of a record; with the analysis itself, for plots and the page."""

    content: OrdersReport
    analysis: SignalAnalysis | None = field(default=None)
    predicted: tuple[tuple[float | None, float], ...] = ()
    """Speeds [1/min] (None: any) and natural frequencies [Hz] computed elsewhere, for the waterfall."""

    def text(self, units: str = "metric") -> str:
        """Return the analysis as lines for people; always metric."""
        from autobalance.signals.show import orders_text

        return orders_text(self.content.found)

    def plots(self) -> Plots:
        """Return spectrum, waterfall, order map, cuts, and the envelope and circles that were requested."""
        from autobalance.signals.show import orders_plots

        return Plots(
            {} if self.analysis is None else orders_plots(self.analysis, self.content.found, self.predicted)
        )

    def files(self) -> Mapping[str, bytes]:
        """Return ``orders.html``, a page with the record to zoom into, and ``psd.csv``."""
        from autobalance.signals.answer import psd_csv
        from autobalance.signals.page import orders_page

        if self.analysis is None:
            return {}
        page = orders_page(self.analysis, self.content)
        return {"orders.html": page.encode(), "psd.csv": psd_csv(self.analysis)}

    def reading(self, order: float = 1.0) -> list[float]:
        """Return an order's amplitude and phase [°] as ``influence`` takes them: ``phases = "same"``.

        The phase counts from the tacho's first pulse, so the tacho must give one pulse a turn for two records
        to count from the same place of the shaft.

        Raises
        ------
        FormatError
            If the record has no such order, or counts its angle from anywhere else than one pulse a turn.
        """
        found = self.content.found
        once = found.speed.source == "tacho" and self.content.input.pulses_per_rev == 1
        if not once:
            raise FormatError(
                "a reading for influence needs a tacho with one pulse a turn: its phase counts from there"
            )
        for row in found.orders:
            if row.order == order and row.amplitude is not None and row.phase_deg is not None:
                return [row.amplitude, row.phase_deg]
        raise FormatError(f"order {order:g} is not in this record")


@documented
def orders(
    record: str | Path | Mapping[str, ArrayLike],
    other: str | Path | Mapping[str, ArrayLike] | None = None,
    *,
    channel: str | None = None,
    sample_rate: float | None = None,
    calibration: Mapping[str, float | str] | None = None,
    quantity: Quantity | None = None,
    speed_rpm: float | None = None,
    tacho: str | None = None,
    pulses_per_rev: int = 1,
    threshold: float | None = None,
    window: str = "hann",
    max_order: float = 12.0,
    peaks: int = 20,
    natural: bool = False,
    excitation: str | None = None,
    frequencies: Sequence[float] | None = None,
    bearing: Mapping[str, float] | None = None,
    band: tuple[float, float] | None = None,
    axes: tuple[str, str] | None = None,
    job: str | Path | Job | None = None,
    settings: Sequence[str] = (),
    drive: str | Path | Mapping[str, Any] | None = None,
    campbell: str | Path | Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> OrdersResult:
    """Analyse a recorded signal: its orders, its levels, and their likely causes.

    Parameters
    ----------
    record : path or mapping
        Recorded signal: a CSV, WAV, MATLAB, TDMS (extra) or UFF58 (extra) file. Or header → samples, with
        ``sample_rate``.
    other : path, mapping or None
        Second record, compared with the first order by order.
    channel : str or None
        Name of the channel to analyse; None: the only one that is not a tacho.
    sample_rate : float or None
        Sample rate of a record that does not state its own [Hz]; None: the record's.
    calibration : mapping or None
        Factor that a channel is multiplied by, or its sensitivity, for example accel=100mV/g. Channel →
        factor, or sensitivity as text.
    quantity : {"acceleration", "velocity", "displacement"} or None
        Quantity that channels of motion are integrated to from 2 Hz on, in m/s², mm/s or µm; None: as
        recorded.
    speed_rpm : float or None
        Constant speed of the crank [rpm]; None: by the tacho, else by the orders that the record shows.
    tacho : str or None
        Name of the channel that holds the tacho's pulses.
    pulses_per_rev : int
        Number of the tacho's pulses in a turn.
    threshold : float or None
        Level that the tacho's pulses rise through, in the channel's unit; None: midway between its extremes.
    window : {"hann", "hamming", "blackman", "flattop", "rect"}
        Window of the spectrum.
    max_order : float
        Highest order to analyse.
    peaks : int
        Number of the spectrum's peaks to list.
    natural : bool
        Find natural frequencies in a run-up or a sweep.
    excitation : str or None
        Name of the channel that holds the exciting force, with natural frequencies: they are found in the
        transfer function then.
    frequencies : sequence of float or None
        Frequencies whose crossings with the orders are listed [Hz]; None: the natural ones found.
    bearing : mapping or None
        Geometry of a rolling bearing whose defect orders are listed: balls, their diameter ball and the pitch
        diameter [mm], contact angle [°], speed of its shaft over the crank's (1), for example
        balls=9,ball=7.94,pitch=39.04,contact=0,speed=1.
    band : pair or None
        Lowest and highest frequency of the envelope's band [Hz]; None: the band with the most peaked
        envelope.
    axes : pair of str or None
        Names of two channels at right angles, X and Y, from which rotating and reciprocating unbalance are
        separated. Forward and backward circles of order 1.
    job : path, Job or None
        Job of the engine that was recorded, for the sources of its orders.
    drive : path, mapping or None
        File of the gears, belts and shafts that the crank drives, besides those of the job's ``[drive]``.
    campbell : path, mapping or None
        Report of rotor or torsion whose natural frequencies are drawn over the waterfall.

    Returns
    -------
    OrdersResult

    Raises
    ------
    FormatError, FileError
        If a file or an option is impossible.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(4000) / 2000.0
    >>> result = orders({"accel_g": 0.5 * np.cos(2 * np.pi * 25.0 * t)}, sample_rate=2000.0, speed_rpm=1500)
    >>> [round(row["amplitude"], 9) for row in result.report["orders"][:3]]
    [0.0, 0.5, 0.0]
    """
    from autobalance.signals.analysis import AnalysisOptions, analyse
    from autobalance.signals.answer import Asked, OrdersReport, explained, orders_values

    question = AnalysisOptions(
        channel=channel, speed_rpm=speed_rpm, tacho=tacho, pulses_per_rev=pulses_per_rev, threshold=threshold,
        window=window, max_order=max_order, peaks=peaks, natural=natural, excitation=excitation,
        frequencies_hz=None if frequencies is None else tuple(map(float, frequencies)),
        bearing=None if bearing is None else _bearing(bearing), band_hz=band, axes=axes,
    )  # fmt: skip
    progress = progress or no_progress
    progress("reading the record", 0.0)
    first = _record(record, sample_rate, calibration, quantity, tacho)
    second = None if other is None else _record(other, sample_rate, calibration, quantity, tacho)
    progress("analysing", 0.3)
    analysis = analyse(first, question)
    compared = None if second is None else analyse(second, question)
    engine = None if job is None else _job(job, settings)
    sources = _sources(question, engine, _drive(drive, engine), analysis, progress)
    inputs = Asked(
        **_question_fields(question, first, second, sample_rate, calibration, bearing),
        job=_named(job),
        quantity=quantity,
        drive=_named(drive),
    )
    causes = explained(analysis, sources, compared)
    set_keys: Values = {"job_set": list(settings)} if settings else {}
    return OrdersResult(
        OrdersReport(**set_keys, input=inputs, found=orders_values(analysis, causes, compared)),
        analysis=analysis,
        predicted=() if campbell is None else _predicted(campbell),
    )


def _predicted(source: str | Path | Mapping[str, Any]) -> tuple[tuple[float | None, float], ...]:
    """Return the natural frequencies of a report of ``rotor`` (by speed) or ``torsion`` (at any)."""
    import json

    report = source
    if isinstance(source, str | Path):
        refuse_pipe(source)
        with file_errors(f"read {source}"):
            text = Path(source).read_bytes()
        try:
            report = json.loads(text)
        except (ValueError, RecursionError):
            raise FormatError(f"{source} is not a report of rotor or torsion: it is not JSON") from None
    try:
        if isinstance(report, Mapping) and "campbell" in report:
            rows = report["campbell"]
            return tuple(
                (float(row["speed_rpm"]), float(m["frequency_hz"])) for row in rows for m in row["modes"]
            )
        if isinstance(report, Mapping) and "natural_frequencies_hz" in report:
            return tuple((None, float(f)) for f in report["natural_frequencies_hz"])
    except (KeyError, TypeError, ValueError, OverflowError):
        pass
    raise FormatError("campbell holds no natural frequencies; expected a report of rotor or torsion")


def _record(
    source: str | Path | Mapping[str, ArrayLike],
    sample_rate: float | None,
    calibration: Mapping[str, float | str] | None,
    quantity: Quantity | None,
    tacho: str | None,
) -> SignalRecord:
    from autobalance.signals.formats import read
    from autobalance.signals.record import SignalRecord, calibration_factor

    if isinstance(source, Mapping):
        record = SignalRecord("arrays", "arrays", _channels(source, sample_rate))
    else:
        record = read(source, sample_rate)
    factors = {
        name: calibration_factor(name, value, record.channel(name).unit)
        for name, value in (calibration or {}).items()
    }
    record = record.calibrated(factors)
    if quantity is None:
        return record
    from autobalance.signals.spectra import DERIVED_QUANTITIES, as_quantity

    if quantity not in DERIVED_QUANTITIES:
        raise FormatError(f"quantity is {quantity!r}; known: {', '.join(DERIVED_QUANTITIES)}")
    return as_quantity(record, quantity, tacho)


def _channels(arrays: Mapping[str, ArrayLike], sample_rate: float | None) -> tuple[Channel, ...]:
    import numpy as np

    from autobalance.signals.formats import agreed_rate
    from autobalance.signals.record import Channel, named

    rate = agreed_rate("a mapping of samples", None, sample_rate)
    channels = []
    for header, samples in arrays.items():
        values = np.asarray(samples)
        if values.ndim != 1 or values.size < 2 or values.dtype.kind not in "iuf":
            raise FormatError(f"channel {header!r} is not a list of numbers longer than 1")
        channels.append(Channel(*named(header), rate, values, header=header))
    if not channels:
        raise FormatError("the record holds no channel")
    return tuple(channels)


def _bearing(geometry: Mapping[str, float]) -> BearingSource:
    import math

    from autobalance.signals.sources import BearingSource

    for key in geometry:
        if key not in BEARING_KEYS:
            raise FormatError(f"bearing: {key} is an unknown key; known: {', '.join(BEARING_KEYS)}")
    for key in BEARING_KEYS[:3]:
        if key not in geometry:
            raise FormatError(f"bearing: {key} is missing")
    if float(geometry["balls"]) % 1.0:
        raise FormatError(f"bearing: balls is {geometry['balls']:g}; must be a whole number")
    return BearingSource(
        int(geometry["balls"]), float(geometry["ball"]), float(geometry["pitch"]),
        math.radians(float(geometry.get("contact", 0.0))), float(geometry.get("speed", 1.0)),
    )  # fmt: skip


def _drive(file: str | Path | Mapping[str, Any] | None, job: Job | None) -> list[DriveSources]:
    """Return the gears, belts and shafts that the crank drives, of a separate file and of the job."""
    from autobalance.signals.drive_input import read_drive
    from autobalance.signals.sources import DriveSources

    own = [] if file is None else [read_drive(file)]
    return own if job is None else [*own, *filter(None, (job.table(DriveSources),))]


def _sources(
    question: AnalysisOptions,
    job: Job | None,
    drives: list[DriveSources],
    analysis: SignalAnalysis,
    progress: Progress,
) -> list[OrderSource]:
    from autobalance.signals.sources import bearing_sources, shaft_source

    speed = None if analysis.speed.turning is None else analysis.speed.turning.mean_rpm * RAD_S_PER_RPM
    known = [source for drive in drives for source in drive.sources(speed)]
    known += [] if question.bearing is None else bearing_sources(question.bearing)
    if job is None:
        return [shaft_source(), *known]
    progress("measuring the job's crank", 0.6)
    from autobalance.balancing.measured_crank import measure_crank
    from autobalance.runtime import Stopwatch
    from autobalance.signals.order_sources import engine_sources

    turning = analysis.speed.turning
    speed_rpm = None if turning is None else turning.mean_rpm
    crank = measure_crank(job.crankshaft, Stopwatch())
    moving = engine_sources(job, crank, speed_rpm, question.max_order) + known
    return moving + (_torque_sources(job, crank, speed_rpm) if "cycle" in job.raw else [])


def _torque_sources(job: Job, crank: Crank, speed_rpm: float | None) -> list[OrderSource]:
    """Return the torque orders of a job's working cycle, and those of its drives' pull."""
    from autobalance.balancing.engine_from_job import as_measured
    from autobalance.engines.cycle.analysis import CycleAnalysis
    from autobalance.engines.cycle.firing import firing_engine
    from autobalance.signals.order_sources import pull_sources
    from autobalance.signals.sources import torque_sources

    speed = job.balance.service_speed_rad_s if speed_rpm is None else speed_rpm * RAD_S_PER_RPM
    firing = firing_engine(job, crank.anatomy, speed, lambda: as_measured(job, crank))
    analysis = CycleAnalysis(firing, speed)
    rows = [(row.order, row.gas_n_m, row.inertia_n_m) for row in analysis.orders]
    return torque_sources(rows) + pull_sources(analysis)


def _job(source: str | Path | Job, settings: Sequence[str]) -> Job:
    from autobalance.job import load

    return load(Path(source), settings) if isinstance(source, str | Path) else source


def _question_fields(
    question: AnalysisOptions, first: SignalRecord, second: SignalRecord | None, sample_rate: float | None,
    calibration: Mapping[str, float | str] | None, bearing: Mapping[str, float] | None,
) -> Values:  # fmt: skip
    """Return the fields of ``Asked`` that a question and its records have."""
    from autobalance.signals.answer import AskedBearing

    return {
        "record": first.file,
        "record_b": None if second is None else second.file,
        "channel": question.channel,
        "sample_rate": sample_rate,
        "calibration": dict(calibration or {}),
        "speed_rpm": question.speed_rpm,
        "tacho": question.tacho,
        "pulses_per_rev": question.pulses_per_rev if question.tacho is not None else None,
        "threshold": question.threshold,
        "window": question.window,
        "max_order": question.max_order,
        "peaks": question.peaks,
        "natural": question.natural,
        "excitation": question.excitation,
        "frequencies": question.frequencies_hz,
        "bearing": None if bearing is None else AskedBearing(**{"contact": 0.0, "speed": 1.0, **bearing}),
        "band": question.band_hz,
        "axes": question.axes,
    }


def _named(source: object) -> str | None:
    """Return the name of a file; None of what was given in memory."""
    return str(source) if isinstance(source, str | Path) else None

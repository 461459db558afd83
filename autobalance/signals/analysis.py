"""Analysis of a record by a question: speed, spectrum, orders, modes, bearing, axes and warnings."""

from __future__ import annotations

from dataclasses import field
from functools import cached_property

import numpy as np

from autobalance.errors import FormatError
from autobalance.signals.bearing import Defect, SignalEnvelope, defects, envelope, liveliest_band
from autobalance.signals.by_angle import TURN, Turning, WhirlCircles, circles
from autobalance.signals.modes import Mode, modes_of_run_up, modes_of_sweep, modes_of_transfer
from autobalance.signals.record import COSINES, Channel, SignalRecord
from autobalance.signals.sines import Sine, aliasing_note, clipped_share, filled
from autobalance.signals.sources import BearingSource
from autobalance.signals.spectra import MAX_WHOLE, Welch, sines_of, thinned, welch
from autobalance.signals.speed import Crossing, OrderLines, crossings, order_lines, speed_of_record
from autobalance.signals.tacho import TachoPulses, pulses
from autobalance.value_classes import dataclass

STEADY_SPEED_VARIATION = 0.02
"""Largest variation of a steady speed, as a share of its mean; with more it is a run-up."""
MIN_SAMPLES = 16
MAX_SAMPLE_SIZE = 1e60
"""Largest size of a sample: beyond it squares of squares overflow."""
STRONGEST_ORDERS = 6


@dataclass(frozen=True)
class AnalysisOptions:
    """Options of an analysis, named as those of the command."""

    channel: str | None = None
    speed_rpm: float | None = None
    tacho: str | None = None
    pulses_per_rev: int = 1
    threshold: float | None = None
    window: str = "hann"
    max_order: float = 12.0
    peaks: int = 20
    natural: bool = False
    excitation: str | None = None
    frequencies_hz: tuple[float, ...] | None = None
    bearing: BearingSource | None = None
    band_hz: tuple[float, float] | None = None
    axes: tuple[str, str] | None = None

    def __post_init__(self) -> None:
        if self.speed_rpm is not None and self.tacho is not None:
            raise FormatError("a speed and a tacho are given; expected one of them")
        if self.speed_rpm is not None and not 0.0 < self.speed_rpm < float("inf"):
            raise FormatError(f"speed_rpm is {self.speed_rpm:g}; must be > 0")
        if self.window not in COSINES:
            raise FormatError(f"window is {self.window!r}; known: {', '.join(COSINES)}")
        if not 0.5 <= self.max_order <= 500.0 or (2 * self.max_order) % 1.0:
            raise FormatError(f"max_order is {self.max_order:g}; must be a whole or half order, ½ to 500")
        if self.peaks < 0:
            raise FormatError(f"peaks is {self.peaks}; must be ≥ 0")
        if self.axes is not None and self.speed_rpm is None and self.tacho is None:
            raise FormatError("axes take their turns from a tacho or a given speed; neither is given")
        for f in self.frequencies_hz or ():
            if not 0.0 < f < float("inf"):
                raise FormatError(f"frequencies hold {f:g}; each must be > 0 Hz")


@dataclass(frozen=True, eq=False)
class Speed:
    """Source of the speed, the shaft's angle (None: unknown), and the uncertainty of the mean speed."""

    source: str | None
    turning: Turning | None
    uncertainty_rpm: float | None = None
    pulses: TachoPulses | None = None

    @property
    def is_steady(self) -> bool:
        """Return whether the speed varies by less than ``STEADY_SPEED_VARIATION``, or is unknown."""
        if self.turning is None:
            return True
        speeds = self.turning.speeds_rpm()
        return bool(speeds.max() - speeds.min() < STEADY_SPEED_VARIATION * self.turning.mean_rpm)


@dataclass(frozen=True, eq=False)
class SignalAnalysis:
    """Results of the analysis of a record."""

    record: SignalRecord
    question: AnalysisOptions
    channel: Channel
    clipped: dict[str, float]
    speed: Speed
    sines: list[Sine]
    lines: OrderLines | None
    modes: list[Mode]
    crossings: list[Crossing]
    defects: list[Defect] | None = None
    envelope: SignalEnvelope | None = None
    circles: WhirlCircles | None = None
    warnings: list[str] = field(default_factory=list)

    @cached_property
    def power(self) -> Welch:
        """Power spectral density of the channel, in the question's window."""
        return welch(self.channel, self.question.window)


def analyse(record: SignalRecord, question: AnalysisOptions) -> SignalAnalysis:
    """Return the results of a question about a record.

    Raises
    ------
    FormatError
        If a named channel does not exist, none is named and there are several, or a tacho has no pulses.
    """
    record = _by_time(record, question)
    warnings = list(record.notes)
    main = _main_channel(record, question)
    others = {
        name: record.channel(name)
        for name in (*(question.axes or ()), question.excitation or main.name)
        if name
    }
    channel, *_ = _whole(warnings, main)
    channels = {main.name: channel}
    for name, each in others.items():
        channels[name] = channel if each is main else _whole(warnings, each)[0]
    clipped = {each.name: _clipped(record, question, each) for each in record.channels}
    warnings += _clip_notes(clipped, {each.name for each in (main, *others.values())})
    if note := aliasing_note(channel):
        warnings.append(note)
    speed = _speed(record, question, channel, warnings)
    count = question.max_order
    lines = _lines(channel, speed, count, warnings)
    modes = _modes(channel, question, channels, speed, lines, warnings) if question.natural else []
    meeting = question.frequencies_hz
    if meeting is None:
        meeting = tuple(mode.frequency_hz for mode in modes)
    found_envelope, found_defects = _bearing(channel, question, speed, warnings)
    return SignalAnalysis(
        record, question, channel, clipped, speed, sines_of(channel, question.window, question.peaks), lines,
        modes, crossings(meeting, question.max_order), found_defects, found_envelope,
        _circles(question, channels, speed), warnings,
    )  # fmt: skip


def _by_time(record: SignalRecord, question: AnalysisOptions) -> SignalRecord:
    if record.samples_per_turn is None:
        return record
    if question.speed_rpm is None:
        raise FormatError(f"{record.file} was taken by angle: give --speed-rpm for its frequencies")
    return record.at_speed(question.speed_rpm)


def _is_tacho(channel: Channel, question: AnalysisOptions, record: SignalRecord) -> bool:
    if question.tacho is not None:
        return channel is record.channel(question.tacho)
    return "tacho" in channel.name.lower()


def _main_channel(record: SignalRecord, question: AnalysisOptions) -> Channel:
    """Return the question's channel, or the only one of the record."""
    if question.channel is not None:
        channel = record.channel(question.channel)
    elif question.axes is not None:
        channel = record.channel(question.axes[0])
    else:
        aside = {id(record.channel(question.excitation))} if question.excitation is not None else set()
        left = [
            each
            for each in record.channels
            if id(each) not in aside and not _is_tacho(each, question, record)
        ]
        if len(left) != 1:
            names = ", ".join(each.name for each in left) or "none"
            raise FormatError(
                f"{record.file} has {len(left)} channels that are not tachos ({names}); "
                "name one with --channel"
            )
        channel = left[0]
    if len(channel) < MIN_SAMPLES:
        raise FormatError(
            f"channel {channel.name!r} has {len(channel)} samples; expected at least {MIN_SAMPLES}"
        )
    return channel


def _whole(warnings: list[str], *channels: Channel) -> list[Channel]:
    """Return channels with gaps filled, and add a warning for each such channel."""
    whole_ones = []
    for channel in channels:
        _check_size(channel)
        whole, note = filled(channel)
        if note:
            warnings.append(note)
        whole_ones.append(whole)
    return whole_ones


def _check_size(channel: Channel) -> None:
    for _, piece in channel.blocks():
        finite = np.abs(piece[np.isfinite(piece)])
        if (greatest := float(finite.max(initial=0.0))) > MAX_SAMPLE_SIZE:
            raise FormatError(
                f"channel {channel.name!r} holds {greatest:.3g}; a signal is below {MAX_SAMPLE_SIZE:g}"
            )


def _clipped(record: SignalRecord, question: AnalysisOptions, channel: Channel) -> float:
    """Return the share of clipped samples; 0 for a tacho, which rests at its extremes rightly."""
    return 0.0 if _is_tacho(channel, question, record) else clipped_share(channel)


def _clip_notes(clipped: dict[str, float], used: set[str]) -> list[str]:
    return [
        f"clipped: {100.0 * share:.3g} % of the samples of channel {name!r} are at the extreme; "
        "its amplitudes are too small, and false orders appear"
        for name, share in clipped.items()
        if share > 0.0 and name in used
    ]


def _speed(record: SignalRecord, question: AnalysisOptions, channel: Channel, warnings: list[str]) -> Speed:
    if question.speed_rpm is not None:
        return Speed("given", _constant_speed(record, question.speed_rpm, channel.duration_s))
    if question.tacho is not None:
        [tacho] = _whole(warnings, record.channel(question.tacho))
        train = pulses(tacho, question.pulses_per_rev, question.threshold)
        if isinstance(train, str):
            warnings.append(f"missing pulses: {train}; order analysis is skipped")
            return Speed("tacho", None)
        warnings += _pulse_notes(train, tacho.name)
        turning = train.turning()
        return Speed("tacho", turning, train.speed_uncertainty_rpm(turning.mean_rpm), train)
    by_itself = speed_of_record(channel) if not question.natural or question.excitation is None else None
    if by_itself is None:
        warnings.append("no speed is given or detected; order analysis is skipped")
        return Speed(None, None)
    warnings.append(
        f"the speed, {by_itself.turning.mean_rpm:.6g} 1/min, is the record's own: that at which orders fit "
        "it best; half or twice of it may fit too, and phases count from where order 1 began"
    )
    return Speed("record", by_itself.turning, by_itself.uncertainty_rpm)


def _constant_speed(record: SignalRecord, speed_rpm: float, duration_s: float) -> Turning:
    """Return a constant speed; a record taken by angle begins at its own angle, at or below 0."""
    if record.samples_per_turn is None or record.start_angle_deg % 360.0 == 0.0:
        return Turning.steady(speed_rpm, duration_s)
    start = np.radians(record.start_angle_deg % 360.0) - TURN
    return Turning(np.array([0.0, duration_s]), start + np.array([0.0, TURN * speed_rpm / 60.0 * duration_s]))


def _pulse_notes(train: TachoPulses, name: str) -> list[str]:
    notes = []
    if train.missing:
        notes.append(
            f"missing pulses: {train.missing} of tacho {name!r} were put in between their neighbours"
        )
    if train.extra:
        notes.append(f"doubled pulses: {train.extra} of tacho {name!r} were taken out")
    if train.pattern:
        notes.append(
            f"tacho {name!r}: its {train.per_turn} pulses are uneven by {100.0 * train.pattern:.2g} % of "
            "their distance, the same each turn; taken for the encoder's own pattern and corrected"
        )
    if train.repeats and train.repeats != train.per_turn:
        notes.append(
            f"tacho {name!r}: its pulses repeat every {train.repeats}, but it has {train.per_turn} a turn; "
            "speed and orders are wrong if that is its count"
        )
    return notes


def _lines(channel: Channel, speed: Speed, max_order: float, warnings: list[str]) -> OrderLines | None:
    """Return the orders below half the sample rate, or None, with warnings of those left out."""
    if speed.turning is None:
        return None
    fastest = float(speed.turning.speeds_rpm().max()) / 60.0
    top = min(max_order, np.floor(2.0 * 0.499 * channel.sample_rate_hz / fastest) / 2.0)
    if top < max_order:
        warnings.append(
            f"aliasing: order {max_order:g} reaches {max_order * fastest:.6g} Hz, half the sample rate is "
            f"{0.5 * channel.sample_rate_hz:.6g}; orders above {top:g} cannot be resolved"
        )
    lines = order_lines(channel, speed.turning, top) if top >= 0.5 else None
    if lines is None:
        warnings.append(f"the record holds {speed.turning.turns:.3g} turns; orders need two whole ones")
    return lines


def _modes(
    channel: Channel, question: AnalysisOptions, others: dict[str, Channel], speed: Speed,
    lines: OrderLines | None, warnings: list[str],
) -> list[Mode]:  # fmt: skip
    """Return modes from the transfer function, else the orders of a run-up, else the response alone."""
    if question.excitation is not None:
        force = others[question.excitation]
        _refuse_other_rate(channel, force)
        length = min(len(channel), len(force))
        response, thin = thinned(channel, length)
        return modes_of_transfer(response, thinned(force, length)[0], thin)
    response, rate = thinned(channel, len(channel))
    if speed.turning is not None and lines is not None and not speed.is_steady and speed.source != "record":
        strength = np.abs(lines.blocks).max(axis=0)
        strong = np.argsort(-strength)[:STRONGEST_ORDERS]
        orders = [float(lines.orders[k]) for k in strong if strength[k] > 0.03 * strength.max()]
        return modes_of_run_up(response, rate, speed.turning, orders)
    modes = modes_of_sweep(response, rate)
    if speed.turning is not None and speed.is_steady:
        modes = [mode for mode in modes if not _is_order(mode, speed.turning, rate / len(response))]
    if not modes:
        warnings.append("no natural frequency stands out of this record")
    return modes


def _is_order(mode: Mode, turning: Turning, step_hz: float) -> bool:
    """Return whether a line is a half order of a steady speed, which small variations make look damped."""
    speeds = turning.speeds_rpm() / 60.0
    order = round(2.0 * mode.frequency_hz / turning.mean_rpm * 60.0) / 2.0
    off = abs(mode.frequency_hz - order * turning.mean_rpm / 60.0)
    return order > 0.0 and off < order * float(speeds.max() - speeds.min()) + 2.0 * step_hz


def _refuse_other_rate(one: Channel, other: Channel) -> None:
    if abs(one.sample_rate_hz - other.sample_rate_hz) > 1e-9 * one.sample_rate_hz:
        raise FormatError(
            f"channels {one.name!r} and {other.name!r} have different sample rates, "
            f"{one.sample_rate_hz:.10g} and {other.sample_rate_hz:.10g} Hz; together they need one"
        )


def _bearing(
    channel: Channel, question: AnalysisOptions, speed: Speed, warnings: list[str]
) -> tuple[SignalEnvelope | None, list[Defect] | None]:
    if question.bearing is None and question.band_hz is None:
        return None, None
    if len(channel) > MAX_WHOLE:
        warnings.append(f"the envelope is of the first {MAX_WHOLE / channel.sample_rate_hz:.6g} s")
        channel = Channel(channel.name, channel.unit, channel.sample_rate_hz, channel.values(0, MAX_WHOLE))
    band = question.band_hz or liveliest_band(channel)
    band_envelope = envelope(channel, *band)
    if question.bearing is None or speed.turning is None:
        return band_envelope, None if question.bearing is None else []
    bearing_defects = defects(band_envelope, _clipped_to(speed.turning, channel.duration_s), question.bearing)
    if not bearing_defects:
        warnings.append(
            "the envelope is too slow, or the record too short, for the bearing's orders at this speed"
        )
    return band_envelope, bearing_defects


def _clipped_to(turning: Turning, duration_s: float) -> Turning:
    """Return the angle up to the end of the record."""
    if turning.end_s <= duration_s:
        return turning
    times = np.append(turning.times_s[turning.times_s < duration_s], duration_s)
    return Turning(times, turning.angle_rad(times))


def _circles(question: AnalysisOptions, channels: dict[str, Channel], speed: Speed) -> WhirlCircles | None:
    if question.axes is None or speed.turning is None:
        return None
    first, second = (channels[name] for name in question.axes)
    _refuse_other_rate(first, second)
    lines = [
        order_lines(each, speed.turning, min(question.max_order, _top(each, speed)))
        for each in (first, second)
    ]
    if lines[0] is None or lines[1] is None:
        return None
    return circles(1.0, complex(lines[0].amplitudes[1]), complex(lines[1].amplitudes[1]))


def _top(channel: Channel, speed: Speed) -> float:
    fastest = float(speed.turning.speeds_rpm().max()) / 60.0 if speed.turning is not None else 1.0
    return max(1.0, float(np.floor(2.0 * 0.499 * channel.sample_rate_hz / fastest) / 2.0))


def uncertain_ratio(
    a: complex, b: complex, error_a: float, error_b: float
) -> tuple[float | None, float | None]:
    """Return |a|/|b| and its standard uncertainty from the two standard errors; None where b is 0."""
    if b == 0.0:
        return None, None
    ratio = abs(a) / abs(b)
    if not np.isfinite(error_a + error_b) or a == 0.0:
        return ratio, None
    return ratio, float(ratio * np.hypot(error_a / abs(a), error_b / abs(b)))

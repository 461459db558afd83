"""Correction weights on available places and from stock, also with a required sum."""

from __future__ import annotations

import math
import time
from dataclasses import field, replace

import numpy as np

from autobalance.integer_program import IntegerProgram, solution
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# Weights at fixed places, or from stock, with a required vector sum.


Fitted = tuple[float, float]
"""A fitted weight: its angle [rad] and size [g·mm]."""
ROUNDING = 1e-7
"""Relative tolerance on a sum's excess over the stock's reach, for rounding."""


def places_with_sum(total_g_mm: complex, angles_rad: Array) -> tuple[Fitted, ...]:
    """Return the least weights at one or two of some places with a sum; empty without such places."""
    size, angle = abs(total_g_mm), float(np.angle(total_g_mm))
    pairs = []
    for a in angles_rad:
        for b in angles_rad:
            turn = math.sin(b - a)
            if abs(turn) < 1e-9:
                continue
            at_a, at_b = size * math.sin(b - angle) / turn, size * math.sin(angle - a) / turn
            if min(at_a, at_b) >= -1e-9 * size:
                pairs.append((at_a + at_b, ((float(a), at_a), (float(b), at_b))))
    alone = [((float(a), size),) for a in angles_rad if abs(np.exp(1j * a) - np.exp(1j * angle)) < 1e-9]
    chosen = alone[0] if alone else min(pairs)[1] if pairs else ()
    return tuple(each for each in chosen if each[1] > 1e-9 * size)


def weights_with_sum(total_g_mm: complex, stock_g_mm: Array) -> tuple[Fitted, ...]:
    """Return a few weights from stock, any number of each, with their angles, for a sum.

    One if the size is in stock; else two, the pair of smallest sum whose difference is not over the size.
    Else as many of the largest as are needed, turned by equal angles to both sides.
    """
    size, angle = abs(total_g_mm), float(np.angle(total_g_mm))
    if size <= 1e-9 * float(stock_g_mm.min()):
        return ()
    stock = sorted(float(weight) for weight in stock_g_mm)
    same = [weight for weight in stock if math.isclose(weight, size, rel_tol=1e-7)]
    if same:
        return ((angle, same[0]),)
    pairs = [(a, b) for a in stock for b in stock if a <= b and b - a <= size <= (a + b) * (1.0 + ROUNDING)]
    if pairs:
        a, b = min(pairs, key=sum)
        turn_a = math.acos(max(-1.0, min(1.0, (size**2 + a**2 - b**2) / (2.0 * size * a))))
        turn_b = math.acos(max(-1.0, min(1.0, (size**2 + b**2 - a**2) / (2.0 * size * b))))
        return ((angle + turn_a, a), (angle - turn_b, b))
    greatest = stock[-1]
    count = math.ceil(size / greatest * (1.0 - 1e-9))
    middle = count % 2
    turn = math.acos(min(1.0, (size / greatest - middle) / (count - middle)))
    turns = [0.0] * middle + [sign * turn for sign in (1.0, -1.0) for _ in range(count // 2)]
    return tuple((angle + each, greatest) for each in turns)


# Correction weights on available places and from stock: a mixed-integer program over all planes.
#
# The worst weighted residual is minimized. Circles (sizes of residuals, limits, a weight at any angle) are
# replaced by circumscribed polygons, so the solver's bound is a true lower bound. They are refined at the
# solution until the best set is within a known share of that bound.


MAX_BOUND_EXCESS_SHARE = 0.007
"""Largest share by which the worst residual may exceed the bound."""
SOLVER_GAP = 0.003
NEGLIGIBLE_RESIDUAL_SHARE = 1e-6
"""Share of the largest initial reading below which a residual is negligible."""
TANGENTS = 24
"""Sides of each circle's first polygon."""
SECTORS = 24
"""First pieces of the circle of a single weight at any angle."""
ROUNDS = 60
SECONDS = 40.0
"""Longest time of the solver; ``bound`` shows what is not proven by then."""
ROUNDING_SHARE = 1e-7
"""Relative tolerance on the limit of a sum, for rounding."""
TIE_BREAKING_COST = 1e-7
"""Cost of a weight relative to the residual: of equal sets, the smaller is taken."""


@dataclass(frozen=True, eq=False)
class Fitting:
    """Available weights of a plane; None: any angle, any weight, any number.

    ``limit_g_mm`` is of the plane's vector sum, inf without a limit.
    """

    angles_rad: Array | None = None
    weights_g_mm: Array | None = None
    max_weights: int | None = None
    limit_g_mm: float = math.inf

    @property
    def free(self) -> bool:
        """Whether any sum within the limit can be fitted."""
        return self.angles_rad is None and self.weights_g_mm is None


@dataclass(frozen=True, eq=False)
class FittedWeights:
    """The best set: its sum in each plane (N,), its weights (None: any), and its quality.

    ``bound``: no set has a smaller worst residual; ``proven``: the set is near enough to it.
    """

    sums_g_mm: Complex
    split: tuple[tuple[Fitted, ...] | None, ...]
    worst: float
    bound: float
    proven: bool


@dataclass
class _Program:
    """Columns and rows of the program; column 0 is the worst residual."""

    plane: list[int] = field(default_factory=list)
    turn: list[complex] = field(default_factory=list)
    lower: list[float] = field(default_factory=list)
    upper: list[float] = field(default_factory=list)
    whole: list[bool] = field(default_factory=list)
    rows: list[tuple[dict[int, float], float, float]] = field(default_factory=list)

    def column(self, plane: int, turn: complex, lower: float, upper: float, whole: bool = False) -> int:
        self.plane.append(plane)
        self.turn.append(turn)
        self.lower.append(lower)
        self.upper.append(upper)
        self.whole.append(whole)
        return len(self.plane)


@dataclass(frozen=True, eq=False)
class _Scaled:
    """The problem with readings scaled to a largest of 1 and each plane's weights to its influence."""

    rows: Complex
    start: Complex
    units_g_mm: Array
    reach: float


def fitted_weights(
    influence: Complex, initial: Complex, reading_weights: Array, fittings: tuple[Fitting, ...]
) -> FittedWeights:
    """Return the set of weights that minimizes max v_i |initial_i + (α w)_i|.

    Parameters
    ----------
    influence : (M, N) complex
        Reading per g·mm added.
    initial : (M,) complex
        Readings to reduce.
    reading_weights : (M,) float
        v, importance of each reading.
    fittings : tuple of Fitting, (N,)
        Weights that fit in each plane.

    Returns
    -------
    FittedWeights
        Within 0.7 % of the bound, unless the solver ran out of time: see ``bound``.
    """
    scale = float(np.abs(reading_weights * initial).max())
    if scale == 0.0:
        nothing = np.zeros(len(fittings), dtype=complex)
        return FittedWeights(
            nothing, tuple(None if each.free else () for each in fittings), 0.0, 0.0, proven=True
        )
    task = _scaled(influence, initial, reading_weights, scale)
    search = _WeightSearch(task, fittings)
    best = search.run()
    return replace(best, worst=best.worst * scale, bound=best.bound * scale)


def _scaled(influence: Complex, initial: Complex, reading_weights: Array, scale: float) -> _Scaled:
    rows = reading_weights[:, None] * influence / scale
    lengths = np.linalg.norm(rows, axis=0)
    rows = rows / lengths
    least = float(np.linalg.svd(rows, compute_uv=False)[-1])
    # No better set than none has |A y| over twice the initial readings.
    reach = 2.0 * math.sqrt(len(initial)) / least
    return _Scaled(rows, reading_weights * initial / scale, 1.0 / lengths, reach)


class _WeightSearch:
    """Alternation of solution and refinement of the polygons, until solution and bound meet."""

    def __init__(self, task: _Scaled, fittings: tuple[Fitting, ...]) -> None:
        self.task = task
        self.fittings = fittings
        around = 2.0 * math.pi * np.arange(TANGENTS) / TANGENTS
        self.residual_tangents = [list(around) for _ in task.start]
        self.limit_tangents = [list(around) for _ in fittings]
        arcs = 2.0 * math.pi * np.arange(SECTORS) / SECTORS
        self.sectors = [
            [(weight, angle, math.pi / SECTORS) for weight in _single(each) for angle in arcs]
            for each in fittings
        ]

    def run(self) -> FittedWeights:
        best = self._judged(
            tuple(() for _ in self.fittings), np.zeros(len(self.fittings), dtype=complex), 0.0
        )
        end = time.monotonic() + SECONDS
        for _ in range(ROUNDS):
            program = self._program()
            x, bound = self._solved(program, end - time.monotonic())
            bound = max(bound, best.bound)
            weights = self._judged(*self._fitted(program, x), bound) if x is not None else None
            if weights is not None and self._allowed(weights) and weights.worst < best.worst:
                best = weights
            proven = best.worst <= (1.0 + MAX_BOUND_EXCESS_SHARE) * bound + NEGLIGIBLE_RESIDUAL_SHARE
            best = replace(best, bound=bound, proven=proven)
            if x is None or proven or time.monotonic() > end:
                break
            self._refine(program, x)
        return best

    # --- the program ----------------------------------------------------------------------------------------

    def _program(self) -> _Program:
        program = _Program()
        self.pieces = [self._columns(program, plane, each) for plane, each in enumerate(self.fittings)]
        turned = np.array([self.task.rows[:, plane] for plane in program.plane]).T * np.array(program.turn)
        for number, angles in enumerate(self.residual_tangents):
            for angle in angles:
                back = np.exp(-1j * angle)
                row = dict(enumerate((back * turned[number]).real, 1))
                program.rows.append(
                    ({0: -1.0, **row}, -np.inf, -float((back * self.task.start[number]).real))
                )
        for plane, angles in enumerate(self.limit_tangents):
            limit = self._limit(plane)
            if math.isfinite(limit):
                for angle in angles:
                    row = {
                        column: float((turn * np.exp(-1j * angle)).real)
                        for column, (at, turn) in enumerate(zip(program.plane, program.turn, strict=True), 1)
                        if at == plane
                    }
                    program.rows.append((row, -np.inf, limit))
        return program

    def _limit(self, plane: int) -> float:
        """Return the scaled limit of a plane's sum; several weights at any angle reach all sums below."""
        fitting = self.fittings[plane]
        limit = fitting.limit_g_mm
        if (
            fitting.angles_rad is None
            and fitting.weights_g_mm is not None
            and fitting.max_weights is not None
        ):
            limit = min(limit, fitting.max_weights * float(fitting.weights_g_mm.max()))
        return limit / float(self.task.units_g_mm[plane])

    def _columns(self, program: _Program, plane: int, fitting: Fitting) -> list[tuple[int, float, float]]:
        """Add a plane's columns and return those of weights at places: column, angle, g·mm of each."""
        unit = float(self.task.units_g_mm[plane])
        if self.sectors[plane]:
            return self._arcs(program, plane, unit)
        if fitting.angles_rad is None:
            for turn in (1.0, 1.0j):
                program.column(plane, turn, -self.task.reach, self.task.reach)
            return []
        if fitting.weights_g_mm is not None:
            return self._stock(program, plane, fitting, unit)
        return self._places(program, plane, fitting, unit)

    def _places(
        self, program: _Program, plane: int, fitting: Fitting, unit: float
    ) -> list[tuple[int, float, float]]:
        assert fitting.angles_rad is not None
        most = self.task.reach / _least_sine(fitting.angles_rad)
        pieces, chosen = [], {}
        for angle in fitting.angles_rad:
            column = program.column(plane, np.exp(1j * angle), 0.0, most)
            pieces.append((column, float(angle), unit))
            if fitting.max_weights is not None:
                there = program.column(plane, 0.0, 0.0, 1.0, whole=True)
                program.rows.append(({column: 1.0, there: -most}, -np.inf, 0.0))
                chosen[there] = 1.0
        if fitting.max_weights is not None:
            program.rows.append((chosen, 0.0, fitting.max_weights))
        return pieces

    def _stock(
        self, program: _Program, plane: int, fitting: Fitting, unit: float
    ) -> list[tuple[int, float, float]]:
        assert fitting.angles_rad is not None
        assert fitting.weights_g_mm is not None
        pieces = []
        for angle in fitting.angles_rad:
            here = {}
            for weight in fitting.weights_g_mm:
                column = program.column(plane, weight / unit * np.exp(1j * angle), 0.0, 1.0, whole=True)
                pieces.append((column, float(angle), float(weight)))
                here[column] = 1.0
            program.rows.append((here, 0.0, 1.0))
        if fitting.max_weights is not None:
            program.rows.append(({column: 1.0 for column, *_ in pieces}, 0.0, fitting.max_weights))
        return pieces

    def _arcs(self, program: _Program, plane: int, unit: float) -> list[tuple[int, float, float]]:
        """Add one weight at any angle: the triangle round each arc, and the choice of one arc."""
        pieces, one = [], {}
        for weight, middle, half in self.sectors[plane]:
            corners = (np.exp(-1j * half), 1.0 / math.cos(half), np.exp(1j * half))
            shares = [
                program.column(plane, weight / unit * corner * np.exp(1j * middle), 0.0, 1.0)
                for corner in corners
            ]
            chosen = program.column(plane, 0.0, 0.0, 1.0, whole=True)
            program.rows.append(({**dict.fromkeys(shares, 1.0), chosen: -1.0}, 0.0, 0.0))
            pieces.append((chosen, middle, weight))
            one[chosen] = 1.0
        program.rows.append((one, 0.0, 1.0))
        return pieces

    def _solved(self, program: _Program, seconds: float) -> tuple[Array | None, float]:
        """Return the solution (None: out of time) and the lower bound of the worst residual."""
        size = 1 + len(program.plane)
        matrix = np.zeros((len(program.rows), size))
        for number, (row, _, _) in enumerate(program.rows):
            matrix[number, list(row)] = list(row.values())
        whole = np.array([False, *program.whole])
        cost = np.where(whole, TIE_BREAKING_COST, 0.0)
        cost[0] = 1.0
        low, high = zip(*((low, high) for _, low, high in program.rows), strict=True)
        answer = solution(
            IntegerProgram(
                cost,
                whole.astype(int),
                np.array([0.0, *program.lower]),
                np.array([np.inf, *program.upper]),
                matrix,
                np.array(low),
                np.array(high),
                {"mip_rel_gap": SOLVER_GAP, "time_limit": max(1.0, seconds)},
            )
        )
        if answer.x is None:
            return None, 0.0
        return answer.x, max(0.0, answer.bound - float(cost[1:].sum()))

    # --- its solution ---------------------------------------------------------------------------------------

    def _sums(self, program: _Program, x: Array) -> Complex:
        """Return each plane's scaled sum in the program's solution."""
        sums = np.zeros(len(self.fittings), dtype=complex)
        np.add.at(sums, program.plane, np.array(program.turn) * x[1:])
        return sums

    def _fitted(self, program: _Program, x: Array) -> tuple[tuple[tuple[Fitted, ...], ...], Complex]:
        """Return the weights in each plane with places or stock, and each plane's sum [g·mm]."""
        sums = self._sums(program, x) * self.task.units_g_mm
        split: list[tuple[Fitted, ...]] = []
        for plane, fitting in enumerate(self.fittings):
            over = abs(sums[plane]) / (self._limit(plane) * self.task.units_g_mm[plane])
            if over > 1.0 and (fitting.weights_g_mm is None or fitting.angles_rad is None):
                sums[plane] /= over  # a polygon's corner
            fitted = self._split(plane, fitting, x, complex(sums[plane]))
            if not fitting.free:
                sums[plane] = sum(g_mm * np.exp(1j * angle) for angle, g_mm in fitted)
            split.append(fitted)
        return tuple(split), sums

    def _split(self, plane: int, fitting: Fitting, x: Array, total: complex) -> tuple[Fitted, ...]:
        if self.sectors[plane]:
            chosen = [weight for column, _, weight in self.pieces[plane] if x[column] > 0.5]
            return tuple((float(np.angle(total)), weight) for weight in chosen)
        if fitting.angles_rad is None and fitting.weights_g_mm is not None:
            return weights_with_sum(total, fitting.weights_g_mm)
        if fitting.weights_g_mm is not None:
            return tuple((angle, weight) for column, angle, weight in self.pieces[plane] if x[column] > 0.5)
        if fitting.angles_rad is None:
            return ()
        if fitting.max_weights is None:
            return places_with_sum(total, fitting.angles_rad)
        pieces = sorted(
            ((x[column], angle, unit) for column, angle, unit in self.pieces[plane]), reverse=True
        )
        least = 1e-9 * self.task.reach
        kept = [
            (at, float(share) * unit) for share, at, unit in pieces[: fitting.max_weights] if share > least
        ]
        most = abs(sum(g_mm * np.exp(1j * at) for at, g_mm in kept)) / fitting.limit_g_mm
        return tuple((at, g_mm / max(1.0, most)) for at, g_mm in kept)

    def _judged(
        self, split: tuple[tuple[Fitted, ...], ...], sums_g_mm: Complex, bound: float
    ) -> FittedWeights:
        residual = self.task.start + self.task.rows @ (sums_g_mm / self.task.units_g_mm)
        shown = tuple(None if fit.free else each for each, fit in zip(split, self.fittings, strict=True))
        return FittedWeights(sums_g_mm, shown, float(np.abs(residual).max()), bound, proven=False)

    def _allowed(self, weights: FittedWeights) -> bool:
        limits = np.array([each.limit_g_mm for each in self.fittings])
        return bool((np.abs(weights.sums_g_mm) <= (1.0 + ROUNDING_SHARE) * limits).all())

    def _refine(self, program: _Program, x: Array) -> None:
        """Add a tangent to each circle at the solution, and cut the chosen arcs into four."""
        sums = self._sums(program, x)
        residual = self.task.start + self.task.rows @ sums
        for number in np.flatnonzero(np.abs(residual) > x[0]):
            self.residual_tangents[number].append(float(np.angle(residual[number])))
        for plane in range(len(self.fittings)):
            if abs(sums[plane]) > self._limit(plane):
                self.limit_tangents[plane].append(float(np.angle(sums[plane])))
            kept: list[tuple[float, float, float]] = []
            for arc, (column, *_) in zip(self.sectors[plane], self.pieces[plane], strict=False):
                weight, middle, half = arc
                quarters = [(weight, middle + k * half / 4.0, half / 4.0) for k in (-3, -1, 1, 3)]
                kept += quarters if x[column] > 0.5 else [arc]
            self.sectors[plane] = kept


def _single(fitting: Fitting) -> list[float]:
    """Return the stock where a plane takes one weight at any angle, else nothing: more reach any sum."""
    alone = fitting.angles_rad is None and fitting.weights_g_mm is not None and fitting.max_weights == 1
    return (
        [float(weight) for weight in fitting.weights_g_mm]
        if alone and fitting.weights_g_mm is not None
        else []
    )


def _least_sine(angles_rad: Array) -> float:
    """Return the smallest |sin| between two places neither equal nor opposite; 1 without such places."""
    between = np.abs(np.sin(angles_rad[:, None] - angles_rad[None, :]))
    return max(1e-3, float(between[between > 1e-6].min(initial=1.0)))

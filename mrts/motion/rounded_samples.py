# SPDX-License-Identifier: MIT
"""Splines of samples with few digits: smooth within the rounding where it would set the accelerations."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array

Spline = Callable[..., NDArray[np.floating[Any]]]
"""f(at) and f(at, order), for times of Shape (N,)."""

FEWEST_DIGITS, MOST_DIGITS = 3, 8
"""Decimals or significant digits that are looked for: fewer are rather round numbers, more are as good as exact."""

SMALLEST_SIZE = 1e-250
"""Smaller values count as this: powers of ten for their digits overflow."""

WHOLE = 1e-6
"""How far from a whole number a value in units of its last digit may be: rounding of doubles, at most 1e-8."""

SECOND_DERIVATIVE = 4.0
"""Noise of the second derivative of an interpolating spline, in units of the samples' noise by the step squared."""

SMOOTHED_SHARE = 1e-2
"""Share of the largest acceleration in a table that rounding may set before the digits are smoothed."""

FIT_RESIDUAL = 1.2
"""Residual of a fit in units of the rounding's own: 1.05 happens by chance in a hundred samples, more in a few."""

LAST_RESIDUAL = 2.0
"""The same for the fit of most pieces, which a corner of the path may keep from the samples."""

PIECE = 3
"""Samples that a piece of a fit has at least: fewer would follow the rounding."""

DEGREE = 5

COARSELY, CLOSELY = 2, 4
"""Fits are tried with half as many pieces more until one is near enough, with a quarter more where all are compared."""

NEARLY_AT_REST = 0.2
"""Share of the fastest column's rate that is rest at an end of noisy samples: its spline's rate is least sure there."""


def joined(splines: Sequence[Spline]) -> Spline:
    """Splines of k columns as one whose values are Shape (N, k)."""
    return partial(_columns, splines)


def _columns(splines: Sequence[Spline], at: Array, order: int = 0) -> NDArray[np.floating[Any]]:
    return np.column_stack([spline(at, order) for spline in splines])


def splines_through(time: Array, columns: Array) -> tuple[Spline, float]:
    """The C² spline of samples, Shape (N, k), and its largest distance from one.

    It is the cubic spline through them whose ends are free (not-a-knot: a motion may start with an acceleration, which
    natural ends would take for none). Where the samples of a column carry so few digits that its second derivative were
    noise, it is the quintic spline of the fewest pieces that misses them by no more than their rounding, unless a
    corner keeps all of these from that.
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 (slow to import, for tables without rates only)

    noise = np.array([rounding(values) if np.ptp(values) > 0 else 0.0 for values in columns.T])
    if not np.any(noise):
        return CubicSpline(time, columns), 0.0
    exact: list[Spline] = [CubicSpline(time, values) for values in columns.T]
    fits, residual = exact, np.where(noise > 0, np.inf, 0.0)
    for candidates, missed, _ in _fits(time, columns, COARSELY):
        rough = residual > FIT_RESIDUAL * noise
        if not np.any(rough):
            break
        fits, residual = _chosen(rough, candidates, fits), np.where(rough, missed, residual)
    fine = (noise > 0) & (residual <= LAST_RESIDUAL * noise)
    largest = max(float(np.max(np.abs(spline(time, 2)))) for spline in _chosen(fine, fits, exact))
    taken = fine & (SECOND_DERIVATIVE * noise / np.median(np.diff(time)) ** 2 > SMOOTHED_SHARE * largest)
    spline = joined(_chosen(taken, fits, exact))
    return spline, float(np.max(np.abs(spline(time) - columns)[:, taken], initial=0.0))


def _chosen(first: NDArray[np.bool_], ones: list[Spline], others: list[Spline]) -> list[Spline]:
    return [one if is_first else other for is_first, one, other in zip(first, ones, others, strict=True)]


def smoothing_splines(time: Array, columns: Array) -> list[Spline]:
    """For each column the least-squares quintic spline of as many pieces as generalised cross-validation asks for.

    It makes N RSS / (N - p)² least, for p coefficients and the residual sum of squares RSS of N samples (Craven and
    Wahba, Numerische Mathematik, 1979), N > `PIECE` + `DEGREE`: what is smoothed away is as large as the noise seems to
    be. Columns that together are nearly at rest at an end are so exactly, as noise is largest in rates there.
    """
    free = _cross_validated(time, columns, (False, False))
    rates = np.abs(np.column_stack([spline(time, 1) for spline in free]))
    starts, ends = (np.max(rates[[0, -1]], axis=1) <= NEARLY_AT_REST * np.max(rates)).tolist()
    return _cross_validated(time, columns, (starts, ends)) if starts or ends else free


def _cross_validated(time: Array, columns: Array, rests: tuple[bool, bool]) -> list[Spline]:
    best, least = list[Spline](), np.full(columns.shape[1], np.inf)
    for fits, missed, size in _fits(time, columns, CLOSELY, rests):
        score = missed / (len(time) - size)
        best, least = _chosen(score < least, fits, best or fits), np.minimum(score, least)
    return best


def _fits(
    time: Array, columns: Array, closely: int, rests: tuple[bool, bool] = (False, False)
) -> Iterator[tuple[list[Spline], Array, int]]:
    """Least-squares quintic splines of ever more pieces with as many samples each, which may start and end at rest.

    Each time they have a part of `1 / closely` more.
    With them the root mean square of what each misses, Shape (k,), and how many coefficients one has.
    """
    from scipy.interpolate import BSpline  # noqa: PLC0415
    from scipy.sparse import csr_array  # noqa: PLC0415
    from scipy.sparse.linalg import splu  # noqa: PLC0415

    pieces = 1
    while pieces * PIECE + DEGREE <= len(time):
        inner = np.interp(np.linspace(0, len(time) - 1, pieces + 1)[1:-1], np.arange(len(time)), time)
        knots = np.concatenate([np.full(DEGREE + 1, time[0]), inner, np.full(DEGREE + 1, time[-1])])
        basis = csr_array(BSpline.design_matrix(time, knots, DEGREE))
        size = pieces + DEGREE
        own = np.arange(size)
        own[1:] -= rests[0]  # the first two are one where the rate is zero, and the last two
        own[-1] -= rests[1]
        alike = csr_array((np.ones(size), (np.arange(size), own)), shape=(size, own[-1] + 1))
        reduced: Any = basis @ alike
        found = alike @ splu((reduced.T @ reduced).tocsc()).solve(reduced.T @ columns)
        missed = np.sqrt(np.mean((basis @ found - columns) ** 2, axis=0))
        yield [BSpline(knots, column, DEGREE) for column in found.T], missed, size
        pieces += max(1, pieces // closely)


def derivative(time: Array, columns: Array) -> Array:
    """Derivatives at N times of the cubic splines through columns, Shape (N, k); rounding is divided by a step only."""
    from scipy.interpolate import CubicSpline  # noqa: PLC0415

    return np.asarray(CubicSpline(time, columns)(time, 1), dtype=np.float64)


def rounding(values: Array) -> float:
    """Root mean square of what printing has cut off numbers of one kind, 0 if they carry more than `MOST_DIGITS`.

    All are printed with as many decimals, or with as many significant digits.
    """
    size = np.where(values == 0, 1.0, np.maximum(np.abs(values), SMALLEST_SIZE))
    exponent = np.floor(np.log10(size))
    digits = range(FEWEST_DIGITS, MOST_DIGITS + 1)
    fixed = next((d for d in digits if _whole(values * 10.0**d)), None)
    significant = next((d for d in digits if _whole(values * 10.0 ** (d - 1 - exponent))), None)
    if fixed is None and significant is None:
        return 0.0
    unit = np.zeros(len(values)) if fixed is None else np.full(len(values), 10.0**-fixed)
    if significant is not None:
        unit = np.maximum(unit, np.where(values == 0, 0.0, 10.0 ** (exponent + 1 - significant)))
    return float(np.sqrt(np.mean(unit**2) / 12))


def _whole(scaled: Array) -> bool:
    return bool(np.all(np.abs(scaled - np.rint(scaled)) <= WHOLE))

# SPDX-License-Identifier: MIT
"""Splines of samples with few digits: smooth within the rounding where it would set the accelerations."""

from collections.abc import Callable
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

NEARLY_AT_REST = 0.2
"""Share of the fastest column's rate that is rest at an end of noisy samples: its spline's rate is least sure there."""


def splines_through(time: Array, columns: Array) -> tuple[list[Spline], Array]:
    """The C² spline of each column of samples, Shape (N, k), and its largest distance from one, Shape (k,).

    It is the cubic spline through them whose ends are free (not-a-knot: a motion may start with an acceleration, which
    natural ends would take for none). Where the samples carry so few digits that its second derivative were noise, it
    is the quintic spline of the fewest pieces that misses them by no more than their rounding, unless a corner keeps
    all of these from that.
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 (slow to import, for tables without rates only)

    splines: list[Spline] = [CubicSpline(time, values) for values in columns.T]
    noise = np.array([rounding(values) if np.ptp(values) > 0 else 0.0 for values in columns.T])
    moved = np.zeros(len(splines))
    if not np.any(noise):
        return splines, moved
    fits = _fits(time, columns, noise)
    smooth = [fit or spline for fit, spline in zip(fits, splines, strict=True)]
    largest = max(float(np.max(np.abs(spline(time, 2)))) for spline in smooth)
    spurious = SECOND_DERIVATIVE * noise / np.median(np.diff(time)) ** 2
    for index in np.flatnonzero(spurious > SMOOTHED_SHARE * largest):
        fit = fits[index]
        if fit is not None:
            splines[index] = fit
            moved[index] = np.max(np.abs(fit(time) - columns[:, index]))
    return splines, moved


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
    count, least = len(time), np.full(columns.shape[1], np.inf)
    best: list[Spline] = []
    pieces = 1
    while pieces * PIECE + DEGREE <= count:
        fits = _least_squares(time, columns, pieces, rests)
        squares = np.array([np.sum((fit(time) - values) ** 2) for fit, values in zip(fits, columns.T, strict=True)])
        score = count * squares / (count - pieces - DEGREE) ** 2
        best = [fit if better else kept for fit, kept, better in zip(fits, best or fits, score < least, strict=True)]
        least = np.minimum(score, least)
        pieces += max(1, pieces // 4)
    return best


def _least_squares(time: Array, columns: Array, pieces: int, rests: tuple[bool, bool]) -> list[Spline]:
    """Least-squares quintic splines of pieces with as many samples each, which may start and end at rest."""
    from scipy.interpolate import BSpline  # noqa: PLC0415
    from scipy.sparse import csr_array  # noqa: PLC0415
    from scipy.sparse.linalg import splu  # noqa: PLC0415

    knots = _knots(time, pieces)
    basis = csr_array(BSpline.design_matrix(time, knots, DEGREE))
    coefficients = basis.shape[1]
    own = np.arange(coefficients)
    own[1:] -= rests[0]  # the first two are one where the rate is zero, and the last two
    own[-1] -= rests[1]
    alike = csr_array((np.ones(coefficients), (np.arange(coefficients), own)), shape=(coefficients, own[-1] + 1))
    reduced: Any = basis @ alike
    found = alike @ splu((reduced.T @ reduced).tocsc()).solve(reduced.T @ columns)
    return [BSpline(knots, column, DEGREE) for column in found.T]


def _knots(time: Array, pieces: int) -> Array:
    inner = np.interp(np.linspace(0, len(time) - 1, pieces + 1)[1:-1], np.arange(len(time)), time)
    return np.concatenate([np.full(DEGREE + 1, time[0]), inner, np.full(DEGREE + 1, time[-1])])


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


def _fits(time: Array, columns: Array, noise: Array) -> list[Spline | None]:
    """For each column the least-squares spline of the fewest pieces whose residual is that of rounding, if one has it.

    Columns without noise have none.
    """
    from scipy.interpolate import BSpline, make_lsq_spline  # noqa: PLC0415

    count = len(time)
    fits: list[Spline | None] = [None] * len(noise)
    residual = np.where(noise > 0, np.inf, 0.0)
    pieces = 1
    while pieces * PIECE + DEGREE <= count and np.any(residual > FIT_RESIDUAL * noise):
        knots = _knots(time, pieces)
        rough = np.flatnonzero(residual > FIT_RESIDUAL * noise)
        found = make_lsq_spline(time, columns[:, rough], knots, k=DEGREE)
        residual[rough] = np.sqrt(np.mean((found(time) - columns[:, rough]) ** 2, axis=0))
        for place, index in enumerate(rough):
            fits[index] = BSpline(knots, found.c[:, place], DEGREE)
        pieces += max(1, pieces // 2)
    return [
        fit if left <= LAST_RESIDUAL * size else None for fit, left, size in zip(fits, residual, noise, strict=True)
    ]

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


def splines_through(time: Array, columns: Array) -> tuple[list[Spline], Array]:
    """The C² spline of each column of samples.

    It is the cubic spline through them whose ends are free (not-a-knot: a motion may start with an acceleration, which
    natural ends would take for none). Where the samples carry so few digits that its second derivative were noise, it
    is the quintic spline of the fewest pieces that misses them by no more than their rounding, unless a corner keeps
    all of these from that.

    Args:
        time: Shape (N,) [s], strictly increasing.
        columns: Shape (N, k).

    Returns:
        One spline a column, and its largest distance from a sample, Shape (k,), 0 where it passes through all.
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


def smoothing_splines(time: Array, columns: Array, most: float) -> list[Spline | None]:
    """For each column the least-squares quintic spline of the fewest pieces that is near to all samples.

    Args:
        time: Shape (N,) [s], strictly increasing.
        columns: Shape (N, k).
        most: Largest distance from a sample.

    Returns:
        None for a column to which no spline of `PIECE` samples a piece is as near.
    """
    allowed = np.full(columns.shape[1], most)
    fits, residual = _fewest_pieces(time, columns, allowed, lambda off: np.max(np.abs(off), axis=0))
    return [fit if left <= most else None for fit, left in zip(fits, residual, strict=True)]


def derivative(time: Array, columns: Array) -> Array:
    """Derivatives at the samples of the cubic splines through them, Shape (N, k); rounding is divided by a step only.

    Args:
        time: Shape (N,) [s], strictly increasing.
        columns: Shape (N, k).
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415

    return np.asarray(CubicSpline(time, columns)(time, 1), dtype=np.float64)


def rounding(values: Array) -> float:
    """Root mean square of what printing has cut off, 0 if the values carry more than `MOST_DIGITS`.

    Args:
        values: Shape (N,), of one kind: all printed with as many decimals, or with as many significant digits.
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
    fits, residual = _fewest_pieces(time, columns, FIT_RESIDUAL * noise, lambda off: np.sqrt(np.mean(off**2, axis=0)))
    return [
        fit if left <= LAST_RESIDUAL * size else None for fit, left, size in zip(fits, residual, noise, strict=True)
    ]


def _fewest_pieces(
    time: Array, columns: Array, allowed: Array, size: Callable[[Array], Array]
) -> tuple[list[Spline | None], Array]:
    """Least-squares splines of the fewest pieces whose residuals are of the allowed size, or of the most; none for 0.

    Returns:
        The splines, and the sizes of their residuals, Shape (k,); infinite where the samples are too few.
    """
    from scipy.interpolate import BSpline, make_lsq_spline  # noqa: PLC0415

    count = len(time)
    fits: list[Spline | None] = [None] * len(allowed)
    residual = np.where(allowed > 0, np.inf, 0.0)
    pieces = 1
    while pieces * PIECE + DEGREE <= count and np.any(residual > allowed):
        inner = np.interp(np.linspace(0, count - 1, pieces + 1)[1:-1], np.arange(count), time)
        knots = np.concatenate([np.full(DEGREE + 1, time[0]), inner, np.full(DEGREE + 1, time[-1])])
        rough = np.flatnonzero(residual > allowed)
        found = make_lsq_spline(time, columns[:, rough], knots, k=DEGREE)
        residual[rough] = size(found(time) - columns[:, rough])
        for place, index in enumerate(rough):
            fits[index] = BSpline(knots, found.c[:, place], DEGREE)
        pieces += max(1, pieces // 2)
    return fits, residual

# SPDX-License-Identifier: MIT
"""Armature, viscous and Coulomb friction of one joint by bounded least squares, and how sure each is."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array

PARAMETERS = ("armature", "viscous", "coulomb")
"""In the order of the columns of the regression; an offset of the effort follows, which no motor has."""

CONFIDENCE = 0.95
"""Of the intervals."""

INDEPENDENT = 0.01
"""Share of a column that the other columns must leave, or the motion does not tell its parameter from theirs."""

REFERENCE_RAMP = 0.1
"""Time to the joint's fastest speed [s] that gives the largest acceleration to speak of."""

UNCERTAIN = 0.05
"""Share of the torque limit by which half an interval may put the torque in doubt, at the fastest the joint can do."""

BANDWIDTH = 0.5
"""Lags that carry the covariance of residuals, by the root of the number of blocks: with fewer, intervals are too
narrow where residuals follow each other; more do not help with some hundred blocks."""


def fit_joint(
    columns: Array, left_over: Array, used: NDArray[np.bool_], fastest: float, torque_limit: float
) -> tuple[dict[str, NDArray[Any]], float, Array, float]:
    """Least squares of effort - τ_rb = I_a q̈ + b q̇ + τ_c sign(q̇) + offset, with I_a, b, τ_c >= 0.

    Variances come from the residuals: the larger of the two that ordinary least squares and Newey and West (1987)
    give, who let residuals depend on the motion and on each other along time (`used` says where blocks are missing).

    Args:
        columns: q̈, q̇, sign(q̇) of B blocks along time, Shape (B, 3).
        left_over: effort - τ_rb, Shape (B,) [N m or N].
        used: Which blocks count, Shape (B,).
        fastest: Speed that the joint may have [rad/s or m/s].
        torque_limit: That it has [N m or N].

    Returns:
        What `MotorParameter` has, of the `PARAMETERS` of this joint, each Shape (3,); the constant part of the effort
        [N m or N]; what they say of the blocks, Shape (B,) [N m or N]; root mean square of what is left [N m or N].
    """
    from scipy.special import stdtrit  # noqa: PLC0415 (slow to import)

    full = np.column_stack([columns, np.ones(len(columns))])
    X, y = full[used], left_over[used]
    theta, free, half, held = np.zeros(4), np.zeros(4), np.full(3, np.inf), np.zeros(4, dtype=bool)
    reasons = np.full(3, "it hardly moves in the recording")
    if len(y) > X.shape[1]:
        scale = np.sqrt(np.mean(X**2, axis=0))
        scale[scale == 0] = 1.0
        X = X / scale
        independent = np.array([_left_by_others(X, column) > INDEPENDENT for column in range(X.shape[1])])
        free = np.linalg.lstsq(X, y, rcond=INDEPENDENT**2)[0]
        theta, held = _bounded(X, y)
        error = _standard_errors(full / scale, left_over, used, theta, ~held)
        error[held] = _standard_errors(full / scale, left_over, used, free, np.ones(len(free), bool))[held]
        theta, error, free = theta / scale, error / scale, free / scale
        half = float(stdtrit(len(y) - X.shape[1], (1 + CONFIDENCE) / 2)) * error[:3]
        doubt = half * np.array([fastest / REFERENCE_RAMP, fastest, 1.0])
        reasons = _reasons(columns[used], independent, doubt, torque_limit)
    known, fitted = reasons == "", full @ theta
    found = {
        "value": np.where(known, theta[:3], 0.0),
        "half_width": np.where(known, half, np.inf),
        "reasons": reasons,
        "bounded": held[:3] & known,
        "free": np.where(known, free[:3], 0.0),
    }
    left = left_over[used] - fitted[used]
    return found, float(theta[3]), fitted, float(np.sqrt(np.mean(left**2))) if len(left) else 0.0


def _left_by_others(X: Array, column: int) -> float:
    others, one = np.delete(X, column, axis=1), X[:, column]
    size = float(np.linalg.norm(one))
    if size == 0:
        return 0.0
    return float(np.linalg.norm(one - others @ np.linalg.lstsq(others, one, rcond=None)[0])) / size


def _bounded(X: Array, y: Array) -> tuple[Array, NDArray[np.bool_]]:
    from scipy.optimize import lsq_linear  # noqa: PLC0415 (slow to import)

    lower = np.array([0.0, 0.0, 0.0, -np.inf])
    found = lsq_linear(X, y, (lower, np.full(4, np.inf)), method="bvls")
    return np.asarray(found.x, dtype=np.float64), np.asarray(found.active_mask != 0)


def _standard_errors(
    full: Array, left_over: Array, used: NDArray[np.bool_], theta: Array, varied: NDArray[np.bool_]
) -> Array:
    """Of the parameters that are varied, 0 of the others, Shape (4,)."""
    X = np.where(used[:, None], full, 0.0)[:, varied]
    residual = np.where(used, left_over - full @ theta, 0.0)
    count = int(np.count_nonzero(used))
    freedom = max(count - X.shape[1], 1)
    inverse = np.linalg.pinv(X.T @ X)
    ordinary = inverse * (residual @ residual) / freedom
    scores = X * residual[:, None]
    between = scores.T @ scores
    lags = int(BANDWIDTH * np.sqrt(count))
    for lag in range(1, lags + 1):
        crossed = scores[lag:].T @ scores[:-lag]
        between += (1 - lag / (lags + 1)) * (crossed + crossed.T)
    robust = inverse @ between @ inverse * count / freedom
    errors = np.zeros(len(varied))
    errors[varied] = np.sqrt(np.maximum(np.diag(ordinary), np.diag(robust)))
    return errors


def _reasons(columns: Array, independent: NDArray[np.bool_], doubt: Array, torque_limit: float) -> NDArray[np.str_]:
    one_way = np.min(columns[:, 2]) * np.max(columns[:, 2]) > 0
    reasons = []
    for place in range(3):
        if not independent[place]:
            told = ("it hardly accelerates", "it moves at one speed", "it moves at one speed")[place]
            reasons.append("it moves one way only" if one_way and place else told)
        elif doubt[place] > UNCERTAIN * torque_limit:
            share = 100 * doubt[place] / torque_limit
            reasons.append(f"the motion and its noise leave {share:.3g} % of the torque limit in doubt")
        else:
            reasons.append("")
    return np.array(reasons)

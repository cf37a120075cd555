# SPDX-License-Identifier: MIT
"""Arms whose joints do not move a hand in all directions, whatever their posture."""

from collections.abc import Sequence

import numpy as np

from mrts.base.arrays import Array

DEPENDENT = 1e-9
"""Singular value beside the largest below which a direction is lost: rounding leaves 1e-15, a bad posture far more."""

NAMED = 0.05
"""Part of a direction from which on it is named."""

POSTURES = 3
"""Of which the best counts: the first is the arm's own, and may be singular; the others are anywhere."""

GOLDEN = 0.5 * (5**0.5 - 1)
"""Its multiples, whole turns aside, are spread evenly."""

TWIST = tuple(f"{move} {axis}" for move in ("along", "about") for axis in "xyz")
"""Components of a twist in words."""


def postures_for_rank(own: Array) -> Array:
    """Joint positions at which the rank of an arm's Jacobian is that of its structure, Shape (POSTURES, n) [rad or m].

    Args:
        own: The first of them, Shape (n,).
    """
    others = 2 * (np.arange(1, (POSTURES - 1) * len(own) + 1) * GOLDEN % 1) - 1
    return np.concatenate([own[None], others.reshape(POSTURES - 1, len(own))])


def lacking_freedom(joints: Sequence[str], q: Array, jacobians: Array, rows: Sequence[int]) -> str:
    """Why an arm does not move its hand in all directions in any posture, as a sentence; empty if it does in some.

    Args:
        joints: Names of the joints.
        q: From `postures_for_rank`.
        jacobians: Of the tip in base axes there, Shape (POSTURES, w, n).
        rows: Which component of a twist each of their rows is.
    """
    left, values, right = np.linalg.svd(jacobians)
    ranks = np.sum(values > DEPENDENT * values[:, :1], axis=1)
    best = int(np.argmax(ranks))
    rank, needed = int(ranks[best]), len(rows)
    if rank == needed:
        return ""
    of_all = np.linalg.svd(np.concatenate([*jacobians], axis=1))
    never = of_all[0][:, int(np.sum(of_all[1] > DEPENDENT * of_all[1][0])) :]
    named = [TWIST[row] for row, size in zip(rows, np.linalg.norm(never, axis=1), strict=True) if size > NAMED]
    if len(named) == needed - rank:
        lost = f"In no posture does it move {', '.join(named)} (base axes)"
    else:
        combined = "; ".join(_combination(direction, rows) for direction in left[best, :, rank:].T)
        posture = ", ".join(f"{position:.3g}" for position in q[best])
        lost = f"Which are lost depends on the posture: at [{posture}] it does not move {combined} (base axes)"
    dependent = np.linalg.norm(right[best, rank:], axis=0) > DEPENDENT
    together = np.linalg.svd(jacobians[best][:, dependent], compute_uv=False)
    some = f"{', '.join(name for name, is_one in zip(joints, dependent, strict=True) if is_one)} together give only"
    part = f"{some} {int(np.sum(together > DEPENDENT * values[best, 0]))}. " if np.any(dependent) else ""
    return (
        f"its {len(joints)} joints move its hand in {rank} independent directions, but holding the object takes "
        f"{needed}. {part}{lost}."
    )


def _combination(direction: Array, rows: Sequence[int]) -> str:
    parts = zip(direction * np.sign(direction[np.argmax(np.abs(direction))]), rows, strict=True)
    return " ".join(f"{size:+.2g} {TWIST[row]}" for size, row in parts if abs(size) > NAMED)

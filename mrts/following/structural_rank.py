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
    """Joint positions at which an arm's Jacobian has the rank of its structure, Shape (POSTURES, n), its own first."""
    others = 2 * (np.arange(1, (POSTURES - 1) * len(own) + 1) * GOLDEN % 1) - 1
    return np.concatenate([own[None], others.reshape(POSTURES - 1, len(own))])


def lacking_freedom(joints: Sequence[str], jacobians: Array, rows: Sequence[int]) -> str:
    """Why an arm does not move its hand in all directions in any posture, as a sentence; empty if it does in some.

    Jacobians of the tip in base axes are those at `postures_for_rank`, Shape (POSTURES, w, n).
    """
    values, right = np.linalg.svd(jacobians)[1:]
    ranks = np.sum(values > DEPENDENT * values[:, :1], axis=1)
    best = int(np.argmax(ranks))
    rank, needed = int(ranks[best]), len(rows)
    if rank == needed:
        return ""
    directions, sizes, _ = np.linalg.svd(np.concatenate([*jacobians], axis=1))
    never = directions[:, int(np.sum(sizes > DEPENDENT * sizes[0])) :]
    named = [TWIST[row] for row, size in zip(rows, np.linalg.norm(never, axis=1), strict=True) if size > NAMED]
    always = len(named) == needed - rank
    lost = f"In no posture does it move {', '.join(named)}" if always else "Which are lost depends on the posture"
    dependent = np.linalg.norm(right[best, rank:], axis=0) > DEPENDENT
    together = np.linalg.matrix_rank(jacobians[best][:, dependent], DEPENDENT * values[best, 0])
    some = ", ".join(name for name, is_one in zip(joints, dependent, strict=True) if is_one)
    part = f"{some} together give only {together}. " if some else ""
    return (
        f"its {len(joints)} joints move its hand in {rank} independent directions, but holding the object takes "
        f"{needed}. {part}{lost} (base axes)."
    )

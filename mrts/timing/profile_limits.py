# SPDX-License-Identifier: MIT
"""What limits the fastest timing, segment by segment."""

from collections.abc import Sequence

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.program.load_sharing import LoadSharing
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.program.trajectory_programs import motion_ranges
from mrts.timing.retimed_motion import TimedPiece, at_segment_ends
from mrts.timing.smooth_piece import SmoothPiece

BINDING = 1e-6
"""A limit binds where the motion could be no faster by more than this share of c²."""


def profile_limits(
    cell: Cell, pieces: Sequence[TimedPiece], sharing: LoadSharing | None, loads: Sequence[Array]
) -> list[tuple[str, float]]:
    """The limits that bind, each with its share of the duration, most first.

    A point of a region's edge is one where the motion, faster or slower as a whole, would have c² <= 1; the rows that
    bind there are the edge's.

    Args:
        cell: The cell.
        pieces: The retimed path.
        sharing: A fixed distribution of the load, None for a free one.
        loads: Load vectors that are carried, each Shape (10,).

    Raises:
        SolverError: If no solver answers.
    """
    duration = sum(float(np.sum(part.segment_times)) for part in pieces)
    shares: dict[str, float] = {}
    for part in pieces:
        rows: list[set[str]] = [set() for _ in part.piece.step]
        for motion in at_segment_ends(part):
            for load in loads:
                found = motion_ranges(cell, motion, "wrench", sharing, DEFAULT_SOLVER, load, 1 + BINDING)
                for segment in np.flatnonzero(found.upper <= 1 + BINDING).tolist():
                    rows[segment] |= {str(row) for row in found.binding(segment, "upper")}
        for names, time in zip(rows, part.segment_times.tolist(), strict=True):
            for name in names:
                shares[name] = shares.get(name, 0.0) + time / duration
    return _sorted(shares)


def binding_limits(pieces: Sequence[SmoothPiece]) -> list[tuple[str, float]]:
    """The limits that bind in a smooth timing, each with its share of the duration, most first.

    Args:
        pieces: The path with its timing.
    """
    duration = sum(float(np.sum(part.segment_times)) for part in pieces)
    shares: dict[str, float] = {}
    for part in pieces:
        for names, time in zip(part.binding, part.segment_times.tolist(), strict=True):
            for name in names:
                shares[name] = shares.get(name, 0.0) + time / duration
    return _sorted(shares)


def _sorted(shares: dict[str, float]) -> list[tuple[str, float]]:
    return sorted(shares.items(), key=lambda entry: (-entry[1], entry[0]))

# SPDX-License-Identifier: MIT
"""What limits the fastest timing, segment by segment."""

from collections.abc import Sequence

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.program.load_sharing import LoadSharing
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.program.trajectory_programs import motion_ranges
from mrts.timing.retimed_motion import TimedPiece, at_segment_ends, new_times
from mrts.timing.smooth_piece import SmoothPiece

BINDING = 1e-6
"""A limit binds where the motion could be no faster by more than this share of c²."""


def segment_limits(
    cell: Cell, pieces: Sequence[TimedPiece], sharing: LoadSharing | None, loads: Sequence[Array]
) -> list[tuple[tuple[str, ...], float]]:
    """The limits that bind on every segment of the path, by name, and its share of the duration.

    Args:
        cell: The cell.
        pieces: The retimed path.
        sharing: A fixed distribution of the load, None for a free one.
        loads: Load vectors that are carried, each Shape (10,).
    """
    duration = float(new_times(pieces)[-1])
    found: list[tuple[tuple[str, ...], float]] = []
    for part in pieces:
        binding = part.binding if isinstance(part, SmoothPiece) else _binding(cell, part, sharing, loads)
        shares = (part.segment_times / duration).tolist()
        found += [(tuple(sorted(names)), share) for names, share in zip(binding, shares, strict=True)]
    return found


def _binding(cell: Cell, part: TimedPiece, sharing: LoadSharing | None, loads: Sequence[Array]) -> list[set[str]]:
    """The limits that bind on every segment.

    A point of a region's edge is one where the motion, faster or slower as a whole, would have c² <= 1; the rows that
    bind there are the edge's.
    """
    rows: list[set[str]] = [set() for _ in part.piece.step]
    for motion in at_segment_ends(part):
        for load in loads:
            found = motion_ranges(cell, motion, "wrench", sharing, DEFAULT_SOLVER, load, 1 + BINDING)
            for segment in np.flatnonzero(found.upper <= 1 + BINDING).tolist():
                rows[segment] |= {str(row) for row in found.binding(segment, "upper")}
    return rows

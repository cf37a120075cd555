# SPDX-License-Identifier: MIT
"""What rivals answer too, of a whole `mrts.retime`: the fastest timing alone."""

import numpy as np

import mrts
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.scaling.scale import FactorQuestion
from mrts.timing.fastest_timing import fastest_timing


def timing_alone(constant: mrts.ScalingResult) -> float:
    """Duration of the fastest timing from rows to profile: the answer without torques, comparison and dense check [s].

    Args:
        constant: Of the cell and the motion, found before.
    """
    asked = FactorQuestion(
        cell=constant.cell,
        motion=constant.motion,
        select="auto",
        rule=constant.rule,
        solver=DEFAULT_SOLVER,
        question="nominal",
        tolerance=None,
    )
    found = fastest_timing(asked, constant.motion, (0.0, 0.0), lambda _done, _total: None)
    return float(sum(np.sum(piece.segment_times) for piece in found.pieces))

# SPDX-License-Identifier: MIT
"""What rivals answer too, of a whole `mrts.retime`: the fastest timing alone."""

import numpy as np

import mrts
from mrts.retiming.fastest_timing import fastest_timing
from mrts.scaling.with_torques import ChosenFactor


def timing_alone(constant: mrts.ScalingResult) -> float:
    """Duration of the fastest timing from rows to profile: the answer without torques, comparison and dense check [s].

    Args:
        constant: Of the cell and the motion, found before.
    """
    found = fastest_timing(ChosenFactor(constant, None), "nominal", (0.0, 0.0), lambda _done, _total: None)
    return float(sum(np.sum(piece.segment_times) for piece in found.pieces))

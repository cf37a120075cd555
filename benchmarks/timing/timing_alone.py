# SPDX-License-Identifier: MIT
"""What rivals answer too, of a whole `mrts.retime`: the fastest timing alone."""

import numpy as np

import mrts
from mrts.timing.fastest_timing import fastest_timing
from mrts.timing.result import RetimingResult


def timing_alone(constant: mrts.ScalingResult) -> float:
    """Duration of the fastest timing from rows to profile: the answer without torques, comparison and dense check [s].

    Args:
        constant: Of the cell and the motion, found before.
    """
    asked = RetimingResult(constant.cell, constant.motion, constant.motion, constant.options)
    found = fastest_timing(asked, constant.motion)
    return float(sum(np.sum(piece.segment_times) for piece in found.pieces))

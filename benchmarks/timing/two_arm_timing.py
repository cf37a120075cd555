# SPDX-License-Identifier: MIT
"""The fastest timing of two arms that carry one object, against a direct transcription; see docs/performance.md.

No neighbour asks this: for one arm see one_arm_timing.py. The transcription has all wrenches, speeds and rates as
unknowns of one program that is built outside the measured call and solved by IPOPT; it finds no torques and checks
nothing between the points. Torque and wrench limits on both sides, no velocities. One processor, CPU time, medians of
runs in turn.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

import mrts
from mrts.base.arrays import Array
from mrts.program.smooth_program import segment_times
from mrts.timing.path_pieces import path_pieces

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "oracles"))
from cases import shipped
from interleaved import median_times, on_one_processor, show
from timing_alone import timing_alone
from transcription import transcribed  # the check of the tests

POINTS = (101, 201, 1000)
TRANSCRIBED = 201
"""Points up to which the transcription is solved: it takes seconds."""

REPEATS = 5


def main(numbers: tuple[int, ...] = POINTS, transcribed_points: int = TRANSCRIBED, repeats: int = REPEATS) -> None:
    """Print a table for each number of points."""
    for points in numbers:
        cell, motion = shipped("dual_ur5", points)
        constant = mrts.scale(cell, motion, between=None)
        candidates: dict[str, Callable[[], float]] = {
            "mrts.retime: the whole call": lambda: float(mrts.retime(cell, motion).duration or np.nan),  # noqa: B023 (called in this turn)
            "mrts, rows, regions and profile (fastest_timing)": lambda: timing_alone(constant),  # noqa: B023 (likewise)
        }
        if points <= transcribed_points:
            solve, step = transcribed(cell, motion), path_pieces(cell, motion)[0].step
            candidates["direct transcription by IPOPT, built before"] = lambda: duration(solve, step)  # noqa: B023 (likewise)
        durations = {label: run() for label, run in candidates.items()}
        times = median_times(candidates, repeats)
        print(f"fastest timing, dual UR5-class cell, contact wrench limits, {points} points, one processor, CPU time")
        show(times, points, "point", {label: f"duration {seconds:.6f} s" for label, seconds in durations.items()})


def duration(solve: Callable[[], tuple[bool, Array]], step: Array) -> float:
    """The duration of what is found [s], NaN where nothing is."""
    found, x = solve()
    return float(np.sum(segment_times(step, x))) if found else np.nan


if __name__ == "__main__":
    on_one_processor()
    main()

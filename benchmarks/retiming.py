# SPDX-License-Identifier: MIT
"""The fastest timing of two arms that carry one object, against a direct transcription; see docs/performance.md.

No neighbour asks this: for one arm see one_arm_timing.py. The transcription has all wrenches, speeds and rates as
unknowns of one program that is built outside the measured call and solved by IPOPT. Torque and wrench limits on both
sides, no velocities. One processor, CPU time, medians of runs in turn.
"""

import sys
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from interleaved import median_times, on_one_processor

import mrts
from mrts.reachability.fastest_profile import fastest_profile
from mrts.reachability.speed_regions import speed_regions
from mrts.retiming.path_pieces import PathPiece, path_pieces
from mrts.samples.sample_problem import build_sample_problem

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "oracles"))
from transcription import transcribed  # the check of the tests, built outside the measured calls

CELL = Path(str(files("mrts") / "data")) / "dual_ur5"
POINTS = (1000, 201, 101)
TRANSCRIBED = 201
REPEATS = 5
WHOLE, TRANSCRIPTION = "mrts.retime: the whole call", "direct transcription by IPOPT"


def lift(points: int) -> mrts.ObjectMotion:
    """The shipped lift with another number of samples."""
    description = yaml.safe_load((CELL / "lift_and_turn.yaml").read_text(encoding="utf-8")) | {"samples": points}
    return mrts.sample_motion(mrts.MotionDescription.model_validate(description))


def profile(cell: mrts.Cell, piece: PathPiece) -> Any:
    """Rows, regions and profile: the answer without its torques, its comparison and its check between the samples."""
    regions = speed_regions(build_sample_problem(cell, piece.path, varying=True), float(np.sum(piece.step)))
    return fastest_profile(piece.step, regions, (0.0, 0.0))


def main() -> None:
    """Print the table."""
    on_one_processor()
    cell = mrts.load_cell(CELL / "cell.yaml").without_velocity_limits()
    print("fastest timing, dual UR5-class cell with contact wrench limits, one processor, CPU time")
    for points in POINTS:
        motion = mrts.follow_object(cell, lift(points))
        pieces = path_pieces(motion)
        if not isinstance(pieces, list):
            raise TypeError(pieces)
        candidates: dict[str, Callable[[], Any]] = {
            WHOLE: lambda motion=motion: mrts.retime(cell, motion).duration,  # type: ignore[misc]
            "mrts, rows, regions and profile": lambda piece=pieces[0]: profile(cell, piece),  # type: ignore[misc]
        }
        if points <= TRANSCRIBED:
            candidates[TRANSCRIPTION] = transcribed(cell, motion)
        times = median_times(candidates, REPEATS)
        base = times[WHOLE]
        for label, seconds in times.items():
            print(f"  {points:>4} points  {label:<32}{1e6 * seconds / points:>10.1f} µs a point{seconds / base:>9.2f}x")
        if points <= TRANSCRIBED:
            durations = [candidates[label]() for label in (WHOLE, TRANSCRIPTION)]
            print(f"  {points:>4} points  durations {durations[0]:.6f} and {durations[1]:.6f} s")


if __name__ == "__main__":
    main()

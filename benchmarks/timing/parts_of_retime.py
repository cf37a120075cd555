# SPDX-License-Identifier: MIT
"""What a whole call of `mrts.retime` consists of, one arm and two, and what the check between the samples costs alone.

No rivals: nobody else looks between the samples. Once more with the constant factor that the timing is compared with,
which is found when it is first read. The parts are taken by the library's own functions, in the call of
median time; with the rest they add up to it. One processor, CPU time.
"""

import sys
import tempfile
from pathlib import Path

import mrts
from mrts.program.between_samples import BETWEEN
from mrts.timing.between_samples import excess_between

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cases import along, one_arm, one_arm_path, shipped
from interleaved import median_times, on_one_processor, parts_of, show

POINTS, REPEATS = 1000, 9

PARTS = {
    "mrts.timing.retime:coordinate": "the given motion, its arms closed",
    "mrts.timing.retime:motion_remarks": "remarks, doubtful gaps",
    "mrts.timing.retime:check_held_between": "remarks, doubtful gaps",
    "mrts.timing.fastest_timing:path_pieces": "path and its pieces",
    "mrts.timing.fastest_timing:build_sample_problem": "rows of the regions",
    "mrts.timing.fastest_timing:speed_regions": "regions",
    "mrts.timing.fastest_timing:fastest_profile": "profile",
    "mrts.timing.fastest_timing:rising_profile": "profile",
    "mrts.timing.retime:_played": "plan: motion and its torques",
    "mrts.timing.between_samples:excess_between": "check between the samples",
}
"""Where the whole call calls what; a function that moves must be named anew here."""


def show_parts(title: str, cell: mrts.Cell, motion: mrts.CoordinatedMotion, repeats: int) -> None:
    """Print the parts of one motion's call, and the check alone."""
    points = motion.samples
    whole, parts = parts_of(lambda: mrts.retime(cell, motion), PARTS, repeats)
    print(f"mrts.retime, {title}, {points} points, one processor, CPU time, the median of {repeats} calls")
    notes = {label: f"{seconds / whole:4.0%} of the call" for label, seconds in parts.items()}
    show({"the whole call": whole} | parts, points, "point", notes)
    timed = mrts.retime(cell, motion)
    alone = {
        "mrts.retime: the whole call": lambda: mrts.retime(cell, motion),
        "the whole call, and its constant factor read": lambda: mrts.retime(cell, motion).factor,
        "the check between the samples, alone": lambda: excess_between(timed, BETWEEN),
    }
    show(median_times(alone, repeats), points, "point", {})


def main(points: int = POINTS, repeats: int = REPEATS) -> None:
    """Print both."""
    with tempfile.TemporaryDirectory() as folder:
        cell = one_arm(Path(folder))
    show_parts("one UR5-class arm with its box", cell, along(cell, one_arm_path(cell), points), repeats)
    show_parts("dual UR5-class cell", *shipped("dual_ur5", points), repeats)


if __name__ == "__main__":
    on_one_processor()
    main()

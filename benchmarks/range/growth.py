# SPDX-License-Identifier: MIT
"""How the range of c² grows with the number of samples and of arms; with loads see uncertain_load.py.

A call is `motion_ranges`: terms, rows, both ends of the range, the rows that set them. CPU time of both threads, so
what threads cost is in it.
"""

import sys
import tempfile
from pathlib import Path

import mrts
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_ranges import motion_ranges
from mrts.scaling.range import intersect

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cases import DUAL, ring, shipped, straight_up, stretched
from interleaved import median_times

SAMPLES, REPEATS = 1000, 7
MANY = (100, 1000, 10_000, 100_000, 1_000_000)
MANY_REPEATS = 3
ARMS = 6


def with_samples(few: mrts.CoordinatedMotion, counts: tuple[int, ...]) -> None:
    """Print the growth with the number of samples."""
    cell = mrts.load_cell(DUAL / "cell.yaml")
    print("growth with the number of samples, dual UR5-class cell, CPU time")
    for samples in counts:
        motion = stretched(few, samples)
        run = {"mrts": lambda motion=motion: motion_ranges(motion_rows(cell, motion))}
        seconds = median_times(run, MANY_REPEATS)["mrts"]
        print(f"  {samples:>8} samples{1e3 * seconds:>10.1f} ms{1e6 * seconds / samples:>8.2f} µs a sample", flush=True)


def with_arms(few: mrts.CoordinatedMotion, arms: int, samples: int, repeats: int) -> None:
    """Print the growth with the number of arms."""
    print(f"growth with the number of arms, {samples} samples, CPU time")
    with tempfile.TemporaryDirectory() as folder:
        cells = [ring(Path(folder), number) for number in range(1, arms + 1)]
    motions = [stretched(mrts.follow_object(cell, straight_up(few.object)), samples) for cell in cells]
    found = [motion_ranges(motion_rows(cell, motion)) for cell, motion in zip(cells, motions, strict=True)]
    runs = {
        f"{len(cell.robots)}": lambda cell=cell, motion=motion: motion_ranges(motion_rows(cell, motion))
        for cell, motion in zip(cells, motions, strict=True)
    }
    times = median_times(runs, repeats)
    for (number, seconds), each in zip(times.items(), found, strict=True):
        whole = intersect(each)
        end = whole.upper.c2 if whole.upper else float("nan")
        print(
            f"  {number} arms, {6 * (int(number) - 1) + 1:>2} unknowns{1e6 * seconds / samples:>8.2f} µs a sample"
            f"   ({whole.status.value}, c²⁺ = {end:.4g})"
        )


def main(counts: tuple[int, ...] = MANY, arms: int = ARMS, samples: int = SAMPLES, repeats: int = REPEATS) -> None:
    """Print both."""
    _, few = shipped("dual_ur5", 101)
    with_samples(few, counts)
    with_arms(few, arms, samples, repeats)


if __name__ == "__main__":
    main()

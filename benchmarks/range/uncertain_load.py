# SPDX-License-Identifier: MIT
"""Growth with loads: what the guaranteed range of an uncertain load costs, against the nominal range and random loads.

A call is the range with its study of the load. The guaranteed range asks at the corners of the box; of the planar cell
only the mass matters, so only its ends are looked at. CPU time, medians of runs in turn.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

import mrts
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_ranges import motion_ranges
from mrts.scaling.options import Options
from mrts.scaling.range import intersect, range_at_samples

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cases import MOTIONS, shipped
from interleaved import median_times, on_one_processor, show

SAMPLES, REPEATS, ONCE = 101, 5, 1
DRAWN = 1000
RANGES = {"mass": (0.3, 2.0), "ixx": (0.5, 2.0), "iyy": (0.5, 2.0), "izz": (0.5, 2.0), "mx": (-0.1, 0.1)}


def compare(name: str, samples: int, drawn: int, repeats: int) -> None:
    """Measure one shipped cell and print its table."""
    known, motion = shipped(name, samples)

    def nominal() -> tuple[float, int]:
        found = intersect(motion_ranges(motion_rows(known, motion)))
        return found.upper.c2 if found.upper else float("nan"), 1

    def asked(question: str, names: tuple[str, ...], sharing: mrts.LoadSharing | None = None) -> tuple[float, int]:
        cell = known.with_variation(**{name: RANGES[name] for name in names})
        found, study = range_at_samples(motion_rows(cell, motion, sharing), Options(load=question, sharing=sharing))
        return found.upper.c2 if found.upper else float("nan"), len(study.points) if study else 0

    def sampled() -> tuple[float, int]:
        box = known.with_variation(**RANGES).load_box
        lowest = np.inf
        for point in box.draw(np.random.default_rng(0), drawn) if box else ():
            found = intersect(motion_ranges(motion_rows(known, motion), point.load))
            lowest = min(lowest, found.upper.c2 if found.upper else np.nan)
        return lowest, drawn

    names = tuple(RANGES)
    quick: dict[str, Callable[[], tuple[float, int]]] = {"nominal": nominal}
    for count in range(1, len(names) + 1):
        label = "guaranteed, " + ", ".join(names[:count])
        quick[label] = lambda count=count: asked("guaranteed", names[:count])  # type: ignore[misc]
    quick["guaranteed, all, even distribution"] = lambda: asked("guaranteed", names, mrts.LoadSharing())
    slow: dict[str, Callable[[], tuple[float, int]]] = {
        "grid:51 along the mass": lambda: asked("grid:51", names),
        "possible, all": lambda: asked("possible", names),
        f"{drawn} random loads (no guarantee)": sampled,
    }
    times = median_times(quick, repeats) | median_times(slow, ONCE)
    found = {label: run() for label, run in (quick | slow).items()}
    print(f"uncertain load, cell {name}, one processor, CPU time, median of {repeats}")
    show(times, samples, "sample", {label: f"{loads:>4} loads, c²⁺ {c2:.4f}" for label, (c2, loads) in found.items()})


def main(samples: int = SAMPLES, drawn: int = DRAWN, repeats: int = REPEATS) -> None:
    """Compare on both shipped cells."""
    for name in MOTIONS:
        compare(name, samples, drawn, repeats)


if __name__ == "__main__":
    on_one_processor()
    main()

# SPDX-License-Identifier: MIT
"""The one way in which all benchmarks measure: the candidates in turn, on one processor, CPU time, medians."""

import os
import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any


def on_one_processor() -> None:
    """Keep this process on one processor, so that every candidate has as many threads' worth of it."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


def median_times(candidates: Mapping[str, Callable[[], Any]], repeats: int) -> dict[str, float]:
    """Median CPU time of a call of each candidate [s], after one call that is not counted.

    The candidates take turns, so that a machine whose speed drifts is the same for all of them.

    Args:
        candidates: By name.
        repeats: Counted calls of each.
    """
    times: dict[str, list[float]] = {name: [] for name in candidates}
    for turn in range(repeats + 1):
        for name, run in candidates.items():
            start = time.process_time()
            run()
            if turn:
                times[name].append(time.process_time() - start)
    return {name: statistics.median(taken) for name, taken in times.items()}

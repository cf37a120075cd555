# SPDX-License-Identifier: MIT
"""The one way in which all benchmarks measure and print: candidates in turn, on one processor, CPU time, medians."""

import importlib
import os
import resource
import statistics
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import Any
from unittest.mock import patch

Clock = Callable[[], float]


def on_one_processor() -> None:
    """Keep this process on one processor, so that every candidate has as many threads' worth of it."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


def of_children() -> float:
    """CPU time of child processes that have ended, user and system [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def keeping_bytecode() -> dict[str, str]:
    """The environment of a process that finds its modules compiled from its second run on, as installed ones are."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}


def median_times(
    candidates: Mapping[str, Callable[[], Any]], repeats: int, clock: Clock = time.process_time
) -> dict[str, float]:
    """Median CPU time of a call of each candidate [s], after one call that is not counted.

    The candidates take turns, so that a machine whose speed drifts is the same for all of them.

    Args:
        candidates: By name.
        repeats: Counted calls of each.
        clock: What is measured: this process, or `of_children`.
    """
    times: dict[str, list[float]] = {name: [] for name in candidates}
    for turn in range(repeats + 1):
        for name, run in candidates.items():
            start = clock()
            run()
            if turn:
                times[name].append(clock() - start)
    return {name: statistics.median(taken) for name, taken in times.items()}


def show(times: Mapping[str, float], counts: int | Mapping[str, int], unit: str, notes: Mapping[str, str]) -> None:
    """Print candidates, each with its time and its ratio to the first.

    Args:
        times: Of a call of each candidate [s].
        counts: Units in a call, one number for all or each one's own.
        unit: Its word, as "sample".
        notes: What is said behind some of them.
    """
    each = {label: time / (counts if isinstance(counts, int) else counts[label]) for label, time in times.items()}
    base = next(iter(each.values()))
    for label, seconds in each.items():
        note = f"   {notes[label]}" if label in notes else ""
        print(f"  {label:<52}{1e6 * seconds:>10.2f} µs a {unit}{seconds / base:>9.2f} x{note}", flush=True)


def parts_of(run: Callable[[], Any], functions: Mapping[str, str], repeats: int) -> tuple[float, dict[str, float]]:
    """CPU time of a call, and what each of the library's own functions takes of it [s].

    A function's part leaves out the parts that are inside it, so with the rest, which no function has, they add up to
    the call. The call is the one whose time is the median.

    Args:
        run: The call.
        functions: Places that they are called from, as "package.module:name", each with the label of its part.
        repeats: Calls that are counted, after one that is not.
    """
    taken: dict[str, float] = {}
    inside: list[float] = []

    def timed(function: Callable[..., Any], label: str) -> Callable[..., Any]:
        def measured(*args: Any, **given: Any) -> Any:
            inside.append(0.0)
            start = time.process_time()
            try:
                return function(*args, **given)
            finally:
                whole = time.process_time() - start
                taken[label] = taken.get(label, 0.0) + whole - inside.pop()
                if inside:
                    inside[-1] += whole

        return measured

    calls = []
    with ExitStack() as stack:
        for place, label in functions.items():
            module, _, name = place.partition(":")
            caller = importlib.import_module(module)
            stack.enter_context(patch.object(caller, name, timed(getattr(caller, name), label)))
        for turn in range(repeats + 1):
            taken = dict.fromkeys(functions.values(), 0.0)
            start = time.process_time()
            run()
            whole = time.process_time() - start
            if turn:
                calls.append((whole, taken | {"the rest": whole - sum(taken.values())}))
    return sorted(calls, key=lambda call: call[0])[len(calls) // 2]

# SPDX-License-Identifier: MIT
"""The answers of this state of the library against those of an older one, on random cells and motions.

    make differential BEFORE=c876ebc [CASES=1000] [SEED=0]
    python benchmarks/differential/compare.py BEFORE [CASES [SEED]]

Both states read the same files (`drawn_cases.py`) and answer the same questions (`answers.py`), one after the other, in
processes of their own with the packages of this environment. Files, answers and compiled cells stay in
build/differential. Exit code 1: some answer differs.

Alike are outcomes, and class, file and key of what refuses; c² and durations to 1e-9 (with rates 1e-5); torques and
wrenches to 1e-7 of a limit (with rates 1e-3); the rows that set an end; conflicts, by when, how far and which limits.
Other rows are a tie where they are at their limit in both plans at that end, or two samples set the end to 1e-7, or,
of a conflict, both certificates prove the same widening.
"""

import os
import statistics
import subprocess
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from answers import ENDED, TIE, TOO_LONG, Answer, read_answers
from table import ROOT, checked_out

FOLDER = ROOT / "build" / "differential"
NUMBERS, LOOSE_NUMBERS = 1e-9, 1e-5
TORQUES, LOOSE_TORQUES = 1e-7, 1e-3
LIMIT_SHARES = 0.02
"""Share of a duration by which what limits a timing may differ: single segments may be ties."""
SHOWN = 3


ALIKE = "outcome", "error", "key", "where"
ABSENT: Answer = {"outcome": "not asked", "arrays": {}}
Answers = dict[str, dict[str, Answer]]
"""By case and kind of question."""


class Difference(NamedTuple):
    """What differs in an answer, and how much; a size of 0 is a tie, infinity what has no size."""

    what: str
    size: float


def differences(kind: str, before: Answer, after: Answer) -> Iterator[Difference]:
    """What two answers to a question, each with its arrays, do not have alike.

    Args:
        kind: Of the question.
        before: As from `answers.py`.
        after: Likewise.
    """
    if any(before.get(key) != after.get(key) for key in ALIKE):
        said = [" ".join(str(one[key]) for key in ALIKE if one.get(key)) for one in (before, after)]
        yield Difference(" became ".join(said), np.inf)
        return
    loose = "rates" in kind
    yield from _numbers(before.get("numbers", {}), after.get("numbers", {}), LOOSE_NUMBERS if loose else NUMBERS)
    for side in ("lower", "upper"):
        yield from _rows_at(side, before, after)
    yield from _conflicts(before.get("conflicts", []), after.get("conflicts", []))
    shares = before.get("limits", {}), after.get("limits", {})
    for name in shares[0].keys() | shares[1].keys():
        size = abs(shares[0].get(name, 0.0) - shares[1].get(name, 0.0))
        if size > LIMIT_SHARES:
            yield Difference(f"limited by {name}", size)
    if before.get("stops") != after.get("stops"):
        yield Difference("stops", np.inf)
    yield from _arrays(before["arrays"], after["arrays"], LOOSE_TORQUES if loose else TORQUES)


def _numbers(before: dict[str, float], after: dict[str, float], tolerance: float) -> Iterator[Difference]:
    if before.keys() != after.keys():
        yield Difference("ends", np.inf)
        return
    for name, value in before.items():
        size = 0.0 if value == after[name] else abs(value - after[name]) / max(abs(value), abs(after[name]))
        if not size <= tolerance:
            yield Difference(name, size)


def _rows_at(side: str, before: Answer, after: Answer) -> Iterator[Difference]:
    """Rows that set an end."""
    ends = [one.get(side) for one in (before, after)]
    if None in ends or all(ends[0][key] == ends[1][key] for key in ("rows", "load")):
        return
    differ = {row.rsplit(" (", 1)[0] for row in set(ends[0]["rows"]) ^ set(ends[1]["rows"])}
    at_limit = set(before.get("at limit", [])) & set(after.get("at limit", []))
    other = ends[0]["time"] != ends[1]["time"] and _close(ends[0]["time"], ends[1]["near"])
    tie = other or (differ and differ <= at_limit)
    yield Difference(f"rows at the {side} end" + (" (tie)" if tie else f": {ends[0]['rows']}, {ends[1]['rows']}"),
                     0.0 if tie else np.inf)  # fmt: skip


def _close(time: float | None, times: list[float]) -> bool:
    return time is not None and any(abs(time - other) <= TIE * abs(time) for other in times)


def _conflicts(before: list[dict[str, Any]], after: list[dict[str, Any]]) -> Iterator[Difference]:
    if len(before) != len(after):
        yield Difference(f"conflicts: {len(before)}, {len(after)}", np.inf)
        return
    for one, other in zip(before, after, strict=True):
        for key in ("time", "widening"):
            size = abs(one[key] - other[key]) / (abs(one[key]) or 1.0)
            if not size <= TIE:
                yield Difference(f"{key} of a conflict", size)
        if (one["rows"], one["load"]) != (other["rows"], other["load"]):
            yield Difference("rows of a conflict (tie)", 0.0)


def _arrays(before: dict[str, Any], after: dict[str, Any], tolerance: float) -> Iterator[Difference]:
    """Torques as a share of their limit, or of the largest where there is none; wrenches as one of the largest."""
    for name in ("torque", "wrench"):
        pair = [arrays.get(name) for arrays in (before, after)]
        if pair[0] is None and pair[1] is None:
            continue
        if pair[0] is None or pair[1] is None or pair[0].shape != pair[1].shape:
            yield Difference(f"shape of {name}", np.inf)
            continue
        largest = max(float(np.max(np.abs(values), initial=0.0)) for values in pair) or 1.0
        limit = before["torque limit"] if name == "torque" else np.inf
        size = float(np.max(np.abs(pair[0] - pair[1]) / np.where(np.isfinite(limit) & (limit > 0), limit, largest)))
        if not size <= tolerance:
            yield Difference(name, size)


def compared(before: Answers, after: Answers) -> bool:
    """Print the table, what differs most, and outcomes; whether all is alike."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    seconds: dict[str, tuple[list[float], list[float]]] = defaultdict(lambda: ([], []))
    found: dict[str, list[tuple[float, str, str]]] = defaultdict(list)
    outcomes: Counter[str] = Counter()
    for case, asked in before.items():
        for kind in asked.keys() | after[case].keys():
            pair = [state[case].get(kind) or state[case].get(ENDED) or ABSENT for state in (before, after)]
            worst = list(differences(kind, *pair))
            refused = pair[0]["outcome"] == "refused"
            verdict = "refused alike" if refused else ("equal, with ties" if worst else "equal")
            if any(one.size for one in worst):
                verdict = "differ"
                found[kind] += [(one.size, case, one.what) for one in worst if one.size]
            if pair[0]["outcome"] == TOO_LONG:
                verdict = TOO_LONG
            counts[kind][verdict] += 1
            outcomes[" ".join(str(pair[0][key]) for key in ALIKE[:2] if pair[0].get(key))] += 1
            for times, one in zip(seconds[kind], pair, strict=True):
                times.append(one.get("seconds", 0.0))
    verdicts = ("equal", "equal, with ties", "refused alike", TOO_LONG, "differ")
    print(f"\n| question | asked | {' | '.join(verdicts)} | CPU before, ms: median, sum | now |")
    print("|---|" + "---|" * (len(verdicts) + 3))
    for kind in sorted(counts):
        spent = [f"{1e3 * statistics.median(each or [0]):.3g}, {1e3 * sum(each):.3g}" for each in seconds[kind]]
        cells = [sum(counts[kind].values()), *(counts[kind][verdict] for verdict in verdicts), *spent]
        print(f"| {kind} | {' | '.join(map(str, cells))} |")
    total = sum(outcomes.values()) or 1
    print("\noutcomes before: " + ", ".join(f"{name} {100 * n / total:.3g} %" for name, n in outcomes.most_common()))
    for kind, all_of_kind in sorted(found.items()):
        for size, case, what in sorted(all_of_kind, reverse=True)[:SHOWN]:
            print(f"{kind}, case {case}: {what}" + (f" by {size:.3g}" if np.isfinite(size) else ""))
    return not any(count["differ"] for count in counts.values())


def answers_of_state(packages: Path, cases: Path, out: Path) -> Answers:
    """What the packages in a folder answer, found in a process of its own."""
    environment = os.environ | {"PYTHONPATH": str(packages), "MRTS_CACHE_DIR": str(FOLDER / "cache")}
    environment |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
    command = [sys.executable, Path(__file__).with_name("answers.py"), cases, out]
    subprocess.run(command, check=True, env=environment)  # noqa: S603 (the script beside this one)
    return read_answers(out)


def main(before: str, cases: int = 1000, seed: int = 0) -> bool:
    """Draw, ask both states, compare."""
    from drawn_cases import write_cases  # noqa: PLC0415 (after the path above)

    folder = FOLDER / f"{seed}-{cases}"
    write_cases(folder / "cases", seed, range(cases))
    old = FOLDER / before
    old.mkdir(parents=True, exist_ok=True)
    if not (old / "mrts_codegen").exists():  # it is put there last
        checked_out(before, old)
    first = answers_of_state(old, folder / "cases", folder / "before")
    return compared(first, answers_of_state(ROOT, folder / "cases", folder / "now"))


if __name__ == "__main__":
    sys.exit(not main(sys.argv[1], *map(int, sys.argv[2:])))

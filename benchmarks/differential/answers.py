# SPDX-License-Identifier: MIT
"""Answer the questions of drawn cases by the public Python API of the mrts that is imported; docs in compare.py.

python answers.py FOLDER OUT     # OUT.json and OUT.npz
"""

import json
import os
import resource
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

import numpy as np

import mrts

MOST_SECONDS = 60
"""CPU time of a question: what takes longer is ended, and recorded as such."""

PROCESSES = 2
BLOCK = 8
"""Cases in a row on one structure: few cases compile few of them, and no two processes the same."""

TIE = 1e-7
"""Relative difference of two ends, or distance of a row from its limit, that may be rounding."""

CONTEXT = get_context("fork")
"""What is imported and bound before serves all cases."""

ENDED, TOO_LONG = "ended", f"over {MOST_SECONDS} s"

Answer = dict[str, Any]
"""What is said to a question, as JSON has it; "arrays" beside it."""


def ask(cell: Any, motion: Any, call: str, **options: Any) -> Answer:
    """One question. Where the API or a default (the weights) of two revisions differs, it is made alike."""
    options.setdefault("weights", np.ones(sum(len(robot.joints) for robot in cell.robots)))
    if "shares" in options:
        options["sharing"] = mrts.LoadSharing(options.pop("shares"))
    if call == "scale":
        return of_factor(mrts.scale(cell, motion, **options))
    timed = mrts.retime(cell, motion, **options)
    told: Answer = {"outcome": timed.status.value}
    if timed.conflict is not None:
        told["conflicts"] = [of_conflict(timed.conflict)]
    if timed.retimed is not None:
        told |= {"limits": dict(timed.limits), "stops": timed.stops.tolist(), "arrays": of_plan(timed.retimed)}
        told["numbers"] = {"duration": timed.duration}
    return told


def of_factor(found: Any) -> Answer:
    """What a result at a constant factor says."""
    told: Answer = {"outcome": found.status.value, "numbers": {}}
    samples, done = found.range.samples, found.trajectory
    told["conflicts"] = [of_conflict(one) for one in samples.conflicts]
    for side in ("lower", "upper"):
        end = getattr(found.range, side)
        if found.status.value == "infeasible":
            continue
        told["numbers"][f"c² {side}"] = end.c2
        alike = np.isclose(getattr(samples, side), end.c2, rtol=TIE, atol=0) & (end.time is not None)
        near = samples.time[alike].tolist()
        told[side] = {"time": end.time, "near": near, "rows": rows_told(end.rows), "load": str(end.load)}
    if done is not None:
        told["numbers"] |= {"c² chosen": done.c2, "duration": done.duration}
        uses = found.limit_uses if hasattr(found, "limit_uses") else done.limit_uses  # those of the state before
        told["at limit"] = [name_told(use.name) for use in uses if use.share >= 1 - TIE]
        told["arrays"] = of_plan(found)
    return told


def of_plan(found: Any) -> dict[str, Any]:
    """Torques and wrenches of all arms, each Shape (N, …), and the torque limits."""
    plan = {kind: np.hstack(list(getattr(found, kind).values())) for kind in ("torque", "wrench")}
    sides = [np.abs([robot.torque_lower, robot.torque_upper]).max(axis=0) for robot in found.cell.robots]
    return plan | {"torque limit": np.concatenate(sides)}


def of_conflict(conflict: Any) -> Answer:
    """When limits conflict, by how much, and which."""
    told = {"time": conflict.time, "widening": conflict.widening, "rows": rows_told(conflict.rows)}
    return told | {"load": str(conflict.load)}


def rows_told(rows: Any) -> list[str]:
    """Active rows whatever their wording, in order."""
    return sorted(f"{name_told(row.name)} ({row.side}, {row.limit:g})" for row in rows)


def name_told(name: Any) -> str:
    """What a row limits, whatever its wording."""
    return f"{name.kind} {name.robot}/{name.element}"


def answered(question: Callable[[], Answer]) -> Answer:
    """An answer with its CPU time [s]; what is refused is an answer too."""
    start = time.process_time()
    try:
        told = question()
    except mrts.MrtsError as error:
        where = Path(getattr(error, "where", "")).name
        told = {"outcome": "refused", "error": type(error).__name__, "key": getattr(error, "key", ""), "where": where}
    except Exception as error:  # noqa: BLE001 (a defect is an answer that the other state should not give)
        told = {"outcome": "traceback", "error": type(error).__name__}
    return {"arrays": {}} | told | {"seconds": time.process_time() - start}


def answers_of(folder: Path) -> Iterator[tuple[str, Answer]]:
    """Kinds of question of a case with their answers."""
    loaded: list[Any] = []

    def load() -> Answer:
        loaded.extend([mrts.load_cell(folder / "cell.yaml"), mrts.load_motion(folder / "motion.yaml")])
        return {"outcome": "read"}

    yield "files", answered(load)
    if loaded:
        for kind, question in json.loads((folder / "questions.json").read_text(encoding="utf-8")).items():
            yield kind, answered(partial(ask, *loaded, **question))


def _answer_to(pipe: Connection, folder: Path) -> None:
    """All answers of a case into a pipe, each within its CPU time; what is sent last is None."""
    answers, most = answers_of(folder), resource.getrlimit(resource.RLIMIT_CPU)[1]
    answer: object = folder
    while answer is not None:
        resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time()) + MOST_SECONDS, most))
        answer = next(answers, None)
        pipe.send(answer)


def answer_all(folders: list[Path], told: Callable[[int], None]) -> dict[str, dict[str, Answer]]:
    """Answers by case and kind, every case in a process of its own.

    Args:
        folders: Of the cases.
        told: Told how many are done.
    """
    lanes = [[path for path in folders if int(path.name) // BLOCK % PROCESSES == lane] for lane in range(PROCESSES)]
    said: dict[str, dict[str, Answer]] = {folder.name: {} for folder in folders}
    running: dict[Any, tuple[list[Path], Any, str]] = {}

    def start(lane: list[Path]) -> None:
        if lane:
            folder, (ours, theirs) = lane.pop(0), CONTEXT.Pipe(duplex=False)
            process = CONTEXT.Process(target=_answer_to, args=(theirs, folder))
            process.start()
            theirs.close()
            running[ours] = lane, process, folder.name

    for lane in lanes:
        start(lane)
    while running:
        for pipe in wait(list(running)):
            lane, process, name = running[pipe]
            try:
                answer = pipe.recv()
            except EOFError:
                process.join()
                slow = process.exitcode == -signal.SIGXCPU
                said[name][ENDED] = {"outcome": TOO_LONG if slow else f"died: {process.exitcode}", "arrays": {}}
                answer = None
            if answer is not None:
                said[name][answer[0]] = answer[1]
                continue
            process.join()
            del running[pipe]
            told(len(folders) - sum(map(len, lanes)) - len(running))
            start(lane)
    return said


def main(folder: Path, out: Path) -> None:
    """Answer all cases in a folder."""
    os.nice(10)
    warnings.simplefilter("ignore")
    folders = sorted(path for path in folder.iterdir() if path.is_dir())
    begun = time.monotonic()

    def told(done: int) -> None:
        print(
            f"\r{done} of {len(folders)} cases, {time.monotonic() - begun:.0f} s", end="", file=sys.stderr, flush=True
        )

    print(f"{mrts.__file__}:", file=sys.stderr)
    shipped = Path(mrts.__path__[0]) / "data" / "planar_dual_arm"
    loaded = mrts.load_cell(shipped / "cell.yaml"), mrts.load_motion(shipped / "lift.yaml")
    ask(*loaded, "scale", formulation="torque"), ask(*loaded, "retime", rates=11.5)  # imported once, for all cases
    said = answer_all(folders, told)
    print(file=sys.stderr)
    arrays = {
        f"{case}/{kind}/{name}": values
        for case, answers in said.items()
        for kind, answer in answers.items()
        for name, values in answer.pop("arrays").items()
    }
    np.savez(out.with_suffix(".npz"), **arrays)
    out.with_suffix(".json").write_text(json.dumps(said, ensure_ascii=False), encoding="utf-8")


def read_answers(out: Path) -> dict[str, dict[str, Answer]]:
    """What `main` wrote, as from `answer_all`."""
    said: dict[str, dict[str, Answer]] = json.loads(out.with_suffix(".json").read_text(encoding="utf-8"))
    for answers in said.values():
        for answer in answers.values():
            answer["arrays"] = {}
    with np.load(out.with_suffix(".npz")) as arrays:
        for place, values in arrays.items():
            case, kind, name = place.split("/")
            said[case][kind]["arrays"][name] = values
    return said


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))

# SPDX-License-Identifier: MIT
"""The table of docs/performance.md: what a question costs now, and with an older state of the library, in one run.

    python benchmarks/table.py [REVISION]

Each state answers in a process of its own, kept on one processor; they take turns, one call each. A call is what a
user calls; cells and motions are made before. CPU time, medians. Without a revision only the present state is
measured. Rivals stand in the tables of the folders beside this file, instruction counts in those of
`make instructions` and `make embedded-counts`.
"""

import statistics
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple

from interleaved import keeping_bytecode

ROOT = Path(__file__).resolve().parents[1]
SAMPLES, REPEATS, PROCESSES = 1000, 15, 11
WORKER = "--worker"
PROCESS = "mrts scale, whole process"


class Row(NamedTuple):
    """What is asked of it: a bar that must be reached, and a goal, both in its unit."""

    bar: float
    goal: float
    unit: str
    repeats: int


ROWS = {
    "range of c², one arm": Row(3, 1, "µs a sample", REPEATS),
    "mrts.retime, one arm": Row(6, 3, "µs a point", REPEATS),
    "mrts.retime, two arms": Row(17, 5, "µs a point", REPEATS),
    "the same and its factor, one arm": Row(6, 3, "µs a point", REPEATS),
    "the same and its factor, two arms": Row(17, 5, "µs a point", REPEATS),
    "check between samples, two arms": Row(15, 5, "µs a point", REPEATS),
    "range of c², two arms": Row(1.8, 0.5, "µs a sample", REPEATS),
    PROCESS: Row(350, 200, "ms", PROCESSES),
}
"""`mrts.retime` leaves the constant factor that its timing is compared with until it is read; the rows of "the same"
read it, as every summary does, against the same bars. The bar of the range of two arms is one of instructions, 15 000
of 28 900: here that share of 3.4 µs."""


def questions(samples: int) -> dict[str, Callable[[], Any]]:
    """The calls, cells and motions made."""
    from cases import along, one_arm, one_arm_path, shipped  # noqa: PLC0415 (likewise)

    import mrts  # noqa: PLC0415 (of the state that this worker is of)
    from mrts.program.between_samples import BETWEEN  # noqa: PLC0415 (likewise)
    from mrts.scaling.options import Options  # noqa: PLC0415 (likewise)
    from mrts.scaling.scale import admissible_range  # noqa: PLC0415 (likewise)
    from mrts.timing.between_samples import excess_between  # noqa: PLC0415 (likewise)

    with tempfile.TemporaryDirectory() as folder:
        arm = one_arm(Path(folder))
    alone = along(arm, one_arm_path(arm), samples)
    cell, motion = shipped("dual_ur5", samples)
    timed, nominal = mrts.retime(cell, motion), Options(load="nominal", between=None)
    return {
        "range of c², one arm": lambda: admissible_range(arm, alone, nominal),
        "mrts.retime, one arm": lambda: mrts.retime(arm, alone),
        "mrts.retime, two arms": lambda: mrts.retime(cell, motion),
        # older states have found it by then
        "the same and its factor, one arm": lambda: getattr(mrts.retime(arm, alone), "factor", None),
        "the same and its factor, two arms": lambda: getattr(mrts.retime(cell, motion), "factor", None),
        "check between samples, two arms": lambda: excess_between(timed, BETWEEN),
        "range of c², two arms": lambda: admissible_range(cell, motion, nominal),
    }


def work(samples: int) -> None:
    """Answer each question named on standard input with the CPU time that it took [s]."""
    from cases import DUAL, motion_file  # noqa: PLC0415 (of the state that this worker is of)
    from interleaved import of_children, on_one_processor  # noqa: PLC0415 (likewise)

    on_one_processor()
    asked = questions(samples)
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "mrts", "scale", DUAL / "cell.yaml", motion_file(Path(folder), samples)]
        # from an empty folder: Python looks where it is started before it looks at PYTHONPATH
        processes = {
            PROCESS: lambda: subprocess.run(command, capture_output=True, check=True, cwd=folder)  # noqa: S603
        }
        for line in sys.stdin:
            name = line.strip()
            clock = of_children if name in processes else process_time
            start = clock()
            (asked | processes)[name]()
            print(clock() - start, flush=True)


class State:
    """A state of the library in a process of its own.

    Args:
        path: Folder of its packages.
        samples: Of the motions.
    """

    def __init__(self, path: Path, samples: int) -> None:
        environment = keeping_bytecode() | {"PYTHONPATH": str(path)}
        command = [sys.executable, __file__, WORKER, str(samples)]
        self.process = subprocess.Popen(  # noqa: S603 (this script)
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )

    def seconds(self, name: str) -> float:
        """CPU time of one call."""
        assert self.process.stdin is not None and self.process.stdout is not None  # noqa: S101, PT018 (pipes were asked for)
        self.process.stdin.write(f"{name}\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            sys.exit(f"no answer to '{name}' from {self.process.args!r}")
        return float(line)


def checked_out(revision: str, folder: Path) -> Path:
    """The packages of a revision, put into a folder."""
    archive = subprocess.run(["git", "-C", ROOT, "archive", revision], capture_output=True, check=True).stdout  # noqa: S603, S607
    with tarfile.open(fileobj=BytesIO(archive)) as files:
        files.extractall(folder, filter="data")
    (folder / "mrts_codegen").symlink_to("codegen")
    return folder


def main(revision: str | None = None, samples: int = SAMPLES, repeats: int | None = None) -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        states = {} if revision is None else {revision: State(checked_out(revision, Path(folder)), samples)}
        states["now"] = State(ROOT, samples)
        print(f"{samples} samples, each state on one processor, CPU time, medians of calls in turn")
        print(f"{'':<34}{'bar':>6}{'goal':>6}" + "".join(f"{name:>10}" for name in states))
        for name, row in ROWS.items():
            taken: dict[str, list[float]] = {state: [] for state in states}
            for turn in range((repeats or row.repeats) + 1):
                for state, process in states.items():
                    seconds = process.seconds(name)
                    if turn:
                        taken[state].append(seconds)
            scale = 1e3 if row.unit == "ms" else 1e6 / samples
            medians = [scale * statistics.median(times) for times in taken.values()]
            ratio = f"{medians[0] / medians[-1]:>9.1f} x less" if len(medians) > 1 else ""
            numbers = "".join(f"{value:>10.3g}" for value in medians)
            print(f"{name:<34}{row.bar:>6g}{row.goal:>6g}{numbers} {row.unit:<12}{ratio}", flush=True)
        for process in states.values():
            process.process.communicate()


if __name__ == "__main__":
    if WORKER in sys.argv[1:]:
        work(int(sys.argv[2]))
    else:
        main(*sys.argv[1:2])

# SPDX-License-Identifier: MIT
"""What a cell costs before it answers: generation and compilation once, and loading from the cache after that.

No rivals. Each a new process; CPU time of `mrts.load_cell` and of the compiler that it starts, imports left out.
"""

import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cases import DATA, MOTIONS

REPEATS = 5
LOAD = """
import os, sys, casadi, scipy.spatial.transform, yaml, mrts, mrts.scaling, mrts.motion.motion_file
import yourdfpy, mrts_codegen.generate
start = os.times()
mrts.load_cell(sys.argv[1])
print(sum(os.times()[:4]) - sum(start[:4]))
"""


def load_time(cell: Path, cache: str) -> float:
    """CPU time of `mrts.load_cell` and its children in a process of its own [s]."""
    environment = os.environ | {"MRTS_CACHE_DIR": cache}
    command = [sys.executable, "-c", LOAD, str(cell)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)  # noqa: S603 (our own script)
    return float(done.stdout)


def main(names: tuple[str, ...] = tuple(MOTIONS), repeats: int = REPEATS) -> None:
    """Measure and print the table."""
    print(f"load_cell beyond imports, each in a new process, CPU time, median of {repeats}")
    print(f"{'cell':<20}{'first use [s]':>16}{'from the cache [s]':>20}")
    for name in names:
        first, second = [], []
        for _ in range(repeats):
            with tempfile.TemporaryDirectory() as cache:
                first.append(load_time(DATA / name / "cell.yaml", cache))
                second.append(load_time(DATA / name / "cell.yaml", cache))
        print(f"{name:<20}{statistics.median(first):>16.2f}{statistics.median(second):>20.3f}")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: MIT
"""What a cell costs before it answers: generation and compilation once, and loading from the cache after that."""

import os
import statistics
import subprocess
import sys
import tempfile
from importlib.resources import files
from pathlib import Path

CELLS = ("planar_dual_arm", "dual_ur5")
REPEATS = 5
IMPORTS = (
    "import time, sys, casadi, scipy.spatial.transform, pydantic, yaml, mrts, mrts.scaling, mrts.motion.motion_file;"
)
FIRST = IMPORTS + "import yourdfpy, mrts_codegen.generate;"
LOAD = "t = time.perf_counter(); mrts.load_cell(sys.argv[1]); print(time.perf_counter() - t)"


def load_time(script: str, cell: Path, cache: str) -> float:
    """Seconds that `mrts.load_cell` takes in a process of its own, imports left out."""
    environment = os.environ | {"MRTS_CACHE_DIR": cache}
    done = subprocess.run(  # noqa: S603 (this interpreter, our own script)
        [sys.executable, "-c", script, str(cell)], capture_output=True, text=True, check=True, env=environment
    )
    return float(done.stdout)


def main() -> None:
    """Measure and print the table."""
    print(f"load_cell beyond imports, each in a new process, median of {REPEATS}")
    print(f"{'cell':<20}{'first use [s]':>16}{'from the cache [s]':>20}")
    for name in CELLS:
        cell = Path(str(files("mrts") / "data" / name / "cell.yaml"))
        first, second = [], []
        for _ in range(REPEATS):
            with tempfile.TemporaryDirectory() as cache:
                first.append(load_time(FIRST + LOAD, cell, cache))
                second.append(load_time(FIRST + LOAD, cell, cache))
        print(f"{name:<20}{statistics.median(first):>16.2f}{statistics.median(second):>20.3f}")


if __name__ == "__main__":
    main()

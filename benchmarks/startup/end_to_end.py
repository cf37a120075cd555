# SPDX-License-Identifier: MIT
"""`mrts scale` on the command line with a warm cache: a whole process, what it does step by step, and its memory.

No rivals. CPU time of a child process, user and system, its start and exit included; every line is a process of its
own that does what the lines above it do, and more. Single modules: `python -X importtime`.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cases import DUAL, motion_file
from interleaved import keeping_bytecode, median_times, of_children

SAMPLES, REPEATS = 1000, 11
MORE = 20
"""Times as many samples, to see how memory grows with them."""

STEPS = {
    "Python": "",
    "numpy": "import numpy",
    "the cell, read from the cache": "import sys, mrts; mrts.load_cell(sys.argv[2])",
    "the object's motion": "import sys, mrts; mrts.load_cell(sys.argv[2]); mrts.load_motion(sys.argv[3])",
    "all: mrts scale": "import sys; from mrts.cli import main; main(sys.argv[1:])",
}
PEAK = """
import re, sys
from mrts.cli import main
main(sys.argv[1:])
print(re.search(r"VmHWM:\\s*(\\d+)", open("/proc/self/status").read()).group(1), file=sys.stderr)
"""


def child(script: str, *arguments: str) -> str:
    """Run a script in a process of its own; what it said on standard error."""
    command = [sys.executable, "-c", script, *arguments]
    kept = keeping_bytecode()
    return subprocess.run(command, capture_output=True, text=True, check=True, env=kept).stderr  # noqa: S603 (our own scripts)


def main(samples: int = SAMPLES, repeats: int = REPEATS) -> None:
    """Print the steps, and the memory."""
    with tempfile.TemporaryDirectory() as name:
        few, many = (
            ["scale", str(DUAL / "cell.yaml"), str(motion_file(Path(name), count))]
            for count in (samples, MORE * samples)
        )
        runs = {label: lambda script=script: child(script, *few) for label, script in STEPS.items()}  # type: ignore[misc]
        times = median_times(runs, repeats, of_children)
        peak, most = (int(child(PEAK, *arguments).split()[-1]) for arguments in (few, many))
    print(f"mrts scale, dual UR5-class cell, {samples} samples, warm cache, CPU time of a process, median of {repeats}")
    before = 0.0
    for label, seconds in times.items():
        print(f"  {label:<40}{1e3 * seconds:>8.0f} ms{1e3 * (seconds - before):>+8.0f} ms")
        before = seconds
    growth = 1024 * (most - peak) / ((MORE - 1) * samples)
    print(f"  peak memory {peak / 1024:.0f} MB, growing by {growth:.0f} bytes a sample")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: MIT
"""Sweeps of the shipped dual cell: variants a second, memory, two workers against one, and workers that are killed.

    python benchmarks/variants/sweep_speed.py [VARIANTS]

All that a study may vary in batches varies: bases, grasps, mass. In the last run a random worker is killed every
`KILL_EVERY` seconds; its table must be that of the first.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import numpy as np

import mrts

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cases import DUAL

KILL_EVERY = 5.0
"""[s]"""

STUDY = """
cell: {folder}/cell.yaml
motion: {folder}/lift_and_turn.yaml
vary:
  robots.left.base.xyz[0]: {{from: -0.9, to: -0.65}}
  robots.right.base.xyz[0]: {{from: 0.65, to: 0.9}}
  robots.left.base.xyz[1]: {{from: -0.1, to: 0.1}}
  robots.right.base.xyz[1]: {{from: -0.1, to: 0.1}}
  height: {{sets: ["robots.left.grasp.xyz[2]", "robots.right.grasp.xyz[2]"], from: -0.04, to: 0.04}}
  object.mass: {{from: 4, to: 10}}
sample: sobol
count: {count}
seed: 1
"""


def workers(driver: int) -> list[int]:
    """Processes of loky that a driver has started."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
            if parent == driver and "popen_loky_posix" in (folder / "cmdline").read_text():
                found.append(int(folder.name))
        except OSError:  # gone meanwhile
            continue
    return found


def memory(process: int) -> int:
    """Proportional share of the memory that a process holds [bytes]."""
    try:
        line = next(line for line in Path(f"/proc/{process}/smaps_rollup").read_text().splitlines() if "Pss:" in line)
    except (OSError, StopIteration):
        return 0
    return int(line.split()[1]) * 1024


def swept(study: Path, out: Path, count: int, *, kills: bool) -> tuple[float, int, int]:
    """Wall time [s], most memory of driver and workers together [bytes], and how many were killed."""
    command = [sys.executable, "-m", "mrts", "sweep", str(study), "-o", str(out), "--workers", str(count), "-q"]
    begun, peak, killed, chosen = time.monotonic(), 0, 0, np.random.default_rng(0)
    last = begun
    with subprocess.Popen(command) as driver:  # noqa: S603 (this command)
        while driver.poll() is None:
            time.sleep(0.2)
            now = workers(driver.pid)
            peak = max(peak, sum(memory(each) for each in (driver.pid, *now)))
            if kills and now and time.monotonic() > last + KILL_EVERY:
                with suppress(ProcessLookupError):  # it may just have ended by itself
                    os.kill(int(chosen.choice(now)), signal.SIGKILL)
                    killed, last = killed + 1, time.monotonic()
    if driver.returncode:
        raise SystemExit(driver.returncode)
    return time.monotonic() - begun, peak, killed


def main(variants: int = 100_000) -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        study = folder / "study.yaml"
        study.write_text(STUDY.format(folder=DUAL, count=variants), encoding="utf-8")
        tables = []
        for name, count, kills in (("one", 1, False), ("two", 2, False), ("killed", 2, True)):
            taken, peak, killed = swept(study, folder / name, count, kills=kills)
            text = f"{count} workers: {variants} variants in {taken:.1f} s, {variants / taken:.0f} a second, "
            print(f"{text}{peak / 1e6:.0f} MB, {killed} killed", flush=True)
            tables.append(mrts.read_study_folder(folder / name).table())
        same = all(table.equals(tables[0]) for table in tables)
        print(f"{tables[0].num_rows} rows each; {'the same' if same else 'DIFFERENT'} tables")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))

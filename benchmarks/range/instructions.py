# SPDX-License-Identifier: MIT
"""Instructions a sample of the generated terms and of the kernel, by callgrind: the floor under the measured times."""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import mrts
from mrts.base.manifest import GEOMETRY
from mrts.cell.generation import generated_in_cache
from mrts.kernel.c_text import cell_source
from mrts.kernel.compiler import flags
from mrts.limits import limit_rows

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cases import DATA, MOTIONS, shipped

HERE = Path(__file__).resolve().parents[1]
SAMPLES = 1000
COUNTED = ("mrts_ranges", "mrts_torques", "mrts_lp", "mrts_qp")


def samples_file(path: Path, cell: mrts.Cell, motion: mrts.CoordinatedMotion) -> None:
    """Write what c/instructions.c reads."""
    limits = limit_rows(cell, motion).limits
    matrix = np.hstack([limits.torque_matrix, limits.wrench_matrix])
    row, column = np.nonzero(matrix)
    start = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=len(matrix)))])
    inputs = motion.inputs(cell.load) | {GEOMETRY: cell.geometry}
    inputs["object_rotation"] = inputs["object_rotation"].transpose(0, 2, 1)
    ends = [
        np.maximum(limits.lower, -1e300),
        np.minimum(limits.upper, 1e300),
        np.unique([name.unit for name in limits.names], return_inverse=True)[1],
    ]
    sizes = np.array([motion.samples, len(matrix), cell.geometry.size])
    parts = [sizes, *inputs.values(), start, column, matrix[row, column], *ends]
    path.write_bytes(b"".join(np.ascontiguousarray(part, dtype=np.float64).tobytes() for part in parts))


def count(name: str) -> None:
    """Count one shipped cell and print its line."""
    cell, motion = shipped(name, SAMPLES)
    compiler, valgrind = shutil.which("gcc"), shutil.which("valgrind")
    if compiler is None or valgrind is None:
        sys.exit("this benchmark needs gcc and valgrind: apt-get install gcc valgrind")
    with tempfile.TemporaryDirectory() as folder:
        source, program, data = (Path(folder) / file for file in ("driver.c", "driver", "samples"))
        manifest, generated = generated_in_cache(DATA / name / "cell.yaml")
        generated_text = generated.read_text(encoding="utf-8")
        source.write_text(
            cell_source(manifest, generated_text) + (HERE / "c" / "instructions.c").read_text(encoding="utf-8")
        )
        wanted = [flag for flag in flags((compiler,)) if flag not in {"-fPIC", "-shared"}]
        build = [compiler, *wanted, "-g", "-fno-inline-functions", str(source), "-o", str(program), "-lm"]
        subprocess.run(build, check=True)  # noqa: S603 (fixed commands on files of our own, here and below)
        samples_file(data, cell, motion)
        record = Path(folder) / "callgrind.out"
        run = [valgrind, "--tool=callgrind", f"--callgrind-out-file={record}", str(program), str(data)]
        subprocess.run(run, check=True, capture_output=True)  # noqa: S603
        annotate = shutil.which("callgrind_annotate") or "callgrind_annotate"
        report = [annotate, "--inclusive=yes", "--threshold=100", str(record)]
        text = subprocess.run(report, check=True, capture_output=True, text=True).stdout  # noqa: S603
    print(f"instructions a sample, cell {name}, {motion.samples} samples")
    for function in COUNTED:
        found = re.search(rf"^\s*([\d,]+) .*:(?:\w*_)?{function}\b", text, re.MULTILINE)
        if found:
            print(f"  {function:<14}{int(found.group(1).replace(',', '')) / motion.samples:>10.0f}")


def main() -> None:
    """Count both shipped cells."""
    for name in MOTIONS:
        count(name)


if __name__ == "__main__":
    main()

"""The kernel's memory and end: numbers of any size, sanitizers."""

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
from conftest import DATA, ROOT, UR5

GCC = shutil.which("gcc") or "gcc"
HOSTILE = (np.nan, np.inf, -np.inf, 1e308, -1e308, 1e-300, 1e-320, 5e-324, 0.0)
RUN = """
import sys
import numpy as np
from mrts.kernel.programs import solve_batch
programs = [array for _, array in np.load(sys.argv[1]).items()]
for program in range(len(programs[0])):
    solve_batch(None, *(array[program][None] for array in programs))
"""


def test_programs_of_any_numbers_end(tmp_path):
    """In a process of its own: one that does not end would not end the test either."""
    rng = np.random.default_rng(3)
    k, rows, count = 3, 6, 5000
    g, A = rng.normal(size=(count, k)), rng.normal(size=(count, rows, k))
    low, high = -np.abs(rng.normal(size=(count, rows + k))), np.abs(rng.normal(size=(count, rows + k)))
    for array in (g, A, low, high):
        array[rng.random(array.shape) < 0.1] = rng.choice(HOSTILE)
    np.savez(tmp_path / "programs.npz", g=g, A=A, low=low, high=high)
    subprocess.run([sys.executable, "-c", RUN, tmp_path / "programs.npz"], check=True, timeout=120)


SANITIZED = """
import sys
sys.path.insert(0, sys.argv[1])
import numpy as np
from random_programs import cell_programs, hard_programs
from mrts.kernel import programs
rng = np.random.default_rng(0)
for arms, size in ((2, 3), (2, 6), (3, 6)):
    A, lower, upper = cell_programs(rng, 200, arms, size)
    free = np.full((200, A.shape[2]), np.inf)
    ends = np.hstack([lower, -free]), np.hstack([upper, free])
    ends[0][:, -1], ends[1][:, -1] = 0, 1e9
    programs.solve_batch(None, np.eye(A.shape[2])[-1] * np.ones((200, 1)), A, *ends)
    programs.solve_batch(np.tile(np.eye(A.shape[2]), (200, 1, 1)), np.ones((200, A.shape[2])), A, *ends)
    bound = np.full((200, 2), 1e5)
    programs.projections(A, lower, upper, np.ones_like(A[:, 0]), (-bound, bound))
for k, rows in ((1, 3), (3, 12), (31, 120)):
    for A, lower, upper, _ in hard_programs(rng, max(k, 3), max(rows, 12)).values():
        free = np.full(A.shape[1], np.inf)
        ends = np.concatenate([lower, -free])[None], np.concatenate([upper, free])[None]
        programs.solve_batch(np.eye(A.shape[1])[None], np.ones((1, A.shape[1])), A[None], *ends)
        ends[0][0, -1], ends[1][0, -1] = 0, 1e9
        programs.solve_batch(None, np.eye(A.shape[1])[-1:], A[None], *ends)
"""

SANITIZED_SMOOTH = """
import sys
sys.path.insert(0, sys.argv[1])
from dataclasses import replace
import numpy as np
from smooth_paths import smooth_path
from mrts.program.path_solver import KernelSolver
from mrts.program.smooth_program import Goal
solver, rng = KernelSolver(), np.random.default_rng(0)
kinds = [{"rows": 6, "joints": 6, "changes": False}, {"rows": 12, "free": 6, "blocks": 2, "roots": True, "joints": 3}]
for kind in kinds:
    for nodes in (2, 3, 9):
        program, base = smooth_path(rng, nodes, **kind)
        ended = replace(program, ends=(base.x[0], base.x[-1]), end_free=(base.free[0], base.free[-1]))
        longest = program.duration(base.x)
        for one in (program, ended):
            for goal in (Goal(), Goal(effort=1.0, longest=longest)):
                for moving in (True, False):
                    found = solver.step(one, base.x, goal, moving=moving)
                    if found is not None:
                        solver.step(one, found.x, goal)
            assert solver.torques(one, base.x, base.u) is not None
"""

SANITIZED_VARIANTS = """
import sys
sys.path.insert(0, sys.argv[1])
import tempfile
from pathlib import Path
from wide_studies import wide_study
from mrts.studies.variants import batch_for
for cell, motion in zip(sys.argv[2::2], sys.argv[3::2]):
    for spread in (0.02, 0.3):
        with tempfile.TemporaryDirectory() as folder:
            study = wide_study(Path(folder), Path(cell), Path(motion), spread=spread, count=10)
            batch_for(study).solve(study.points(0, 10), 0)
"""

SANITIZED_SCALING = "import sys; from mrts.cli import main; sys.exit(main(['scale', *sys.argv[1:], '--json', '-']))"

SANITIZED_JOINTS = """
import sys
import mrts
cell = mrts.load_cell(sys.argv[1])
followed = mrts.follow_object(cell, mrts.load_motion(sys.argv[2]))
for last in (2, 3, 5, followed.samples):
    assert mrts.scale(cell, followed.at(range(last)), between=None).motion.samples == last
assert mrts.retime(cell, followed).pieces
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        [SANITIZED, ROOT / "tests" / "cases"],
        [SANITIZED_SMOOTH, ROOT / "tests" / "cases"],
        [SANITIZED_VARIANTS, ROOT / "tests" / "study_cases", DATA / "cell.yaml", DATA / "lift.yaml"],
        [SANITIZED_SCALING, DATA / "cell.yaml", DATA / "lift.yaml"],
        [SANITIZED_SCALING, UR5 / "cell.yaml", UR5 / "lift_and_turn.yaml"],
        [SANITIZED_SCALING, DATA / "cell.yaml", DATA / "lift.yaml", "--share", "equal", "--profile", "optimal"],
        [SANITIZED_JOINTS, UR5 / "cell.yaml", UR5 / "lift_and_turn.yaml"],
    ],
    ids=["programs", "smooth", "variants", "planar", "spatial", "shared", "joints"],
)
def test_the_library_is_clean_under_sanitizers(command, private_cache):
    """The same library, compiled with AddressSanitizer and UndefinedBehaviorSanitizer, under the whole Python path."""
    asan = subprocess.run([GCC, "-print-file-name=libasan.so"], capture_output=True, text=True, check=True).stdout
    environment = os.environ | {
        "CC": f"{os.environ.get('CC', GCC)} -fsanitize=address,undefined -fno-sanitize-recover=all -g1",
        "LD_PRELOAD": asan.strip(),
        "ASAN_OPTIONS": "detect_leaks=0",  # Python's own
        "MRTS_CACHE_DIR": str(private_cache / "sanitized"),
    }
    done = subprocess.run(
        [sys.executable, "-c", *map(str, command)],
        capture_output=True, text=True, check=False, env=environment,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    assert "runtime error" not in done.stderr
    assert any(b"__asan" in library.read_bytes() for library in (private_cache / "sanitized").rglob("*.so"))

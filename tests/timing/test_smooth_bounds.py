"""The search for a smooth timing ends: what it keeps at its bounds, and Ctrl-C inside a long program."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from conftest import DATA
from random_motors import equipped
from shipped_cells import sampled, shipped_motion

import mrts

AT_ONCE = 2.0
"""Seconds in which an interrupted process ends on a busy machine; the program alone takes many times as long."""

LONG = """
import signal
import numpy as np
from smooth_paths import smooth_path
from mrts.program.path_solver import KernelSolver
from mrts.program.smooth_program import Goal
program, base = smooth_path(np.random.default_rng(1), 9, rows=12, free=6)
KernelSolver().step(program, base.x, Goal())  # compiled
program, base = smooth_path(np.random.default_rng(1), 2000, rows=20, free=12, blocks=2)
signal.signal(signal.SIGINT, signal.default_int_handler)  # as in a terminal, whoever runs the tests
print("begins", flush=True)
while True:
    KernelSolver().step(program, base.x, Goal())
"""


@pytest.fixture(scope="module")
def rounded():
    """A timing whose samples are too close for their rounding once limits of jerk ask for more nodes."""
    cell = equipped(mrts.load_cell(DATA.parent / "squeeze" / "cell.yaml"), jerk=950.0)
    return mrts.retime(cell, sampled(shipped_motion("squeeze", samples=58, duration=2.4)), rates=11.5, between=1e-5)


def test_the_timing_with_the_least_excess_is_kept_and_said(rounded):
    assert rounded.status is mrts.RetimingStatus.LOCALLY_AT_SAMPLES
    assert rounded.smooth.steps <= 40
    assert rounded.motion.samples <= 600
    assert 1e-5 < rounded.excess.share < 1e-4
    (told,) = [warning for warning in rounded.to_json()["warnings"] if warning["code"] == "search-stopped"]
    assert f"{rounded.motion.samples} nodes" in told["text"]


def test_an_interrupt_ends_a_program_that_is_at_work():
    paths = [Path(__file__).parents[1] / "cases"]
    script = f"import sys; sys.path[:0] = {[str(path) for path in paths]!r}\n{LONG}"
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        try:
            assert process.stdout.readline() == b"begins\n"
            time.sleep(0.3)
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=AT_ONCE) == -signal.SIGINT
        finally:
            process.kill()

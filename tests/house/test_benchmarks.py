"""The benchmarks run: each script in its smallest size, so that none rots between two releases."""

import math
import re
import runpy
import sys

import pytest
from conftest import ROOT

FOLDER = ROOT / "benchmarks"

SMALLEST = {
    "table.py": {"samples": 20, "repeats": 1},
    "range/ranges.py": {"samples": 20, "repeats": 1},
    "range/against_daqp.py": {"samples": 20, "repeats": 1},
    "range/growth.py": {"counts": (100,), "arms": 2, "samples": 20, "repeats": 1},
    "range/uncertain_load.py": {"samples": 11, "drawn": 2, "repeats": 1},
    "timing/parts_of_retime.py": {"points": 30, "repeats": 1},
    "timing/one_arm_timing.py": {"points": 30, "repeats": 1},
    "timing/two_arm_timing.py": {"numbers": (20,), "transcribed_points": 20, "repeats": 1},
    "timing/coarse_grids.py": {"paths": 1},
    "variants/rates.py": {"variants": 4, "alone": 1, "repeats": 1},
}

ELSEWHERE = {
    "interleaved.py": "what the others measure with",
    "cases.py": "what the others ask about",
    "range/pinocchio_cell.py": "the rival of range/ranges.py",
    "range/instructions.py": "needs valgrind",
    "timing/timing_alone.py": "what two others time",
    "timing/whole_call_instructions.py": "needs valgrind; its calls are those of table.py",
    "closed_loop.py": "its trial is that of tests/program/test_closed_loop.py",
    "smooth_timing.py": "its paths and its rival are those of tests/program/test_against_copp.py",
    "startup/end_to_end.py": "takes 9 s: a dozen processes; table.py asks the same of one",
    "startup/generation_cost.py": "takes 6 s: it generates and compiles",
    "differential/drawn_cases.py": "what compare.py asks",
    "differential/answers.py": "what compare.py compares",
    "differential/compare.py": "tests/house/test_differential.py",
    "embedded/embedded_counts.py": "its helpers are those of tests/codegen",
    "variants/sweep_speed.py": "its sweeps are those of tests/sweeps",
    "paper/paper_identification.py": "tests/commands/test_demo.py",
    "paper/paper_readings.py": "read by paper_identification.py",
}
"""Scripts that are not run here, and why."""

NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*(?:e[-+]?\d+)?|nan|inf)(?![\w.])")


def test_every_script_is_run_or_named():
    scripts = {str(path.relative_to(FOLDER)) for path in FOLDER.rglob("*.py")}
    assert scripts == SMALLEST.keys() | ELSEWHERE.keys()


@pytest.mark.parametrize(
    "script", ["table.py", *(pytest.param(each, marks=pytest.mark.slow) for each in SMALLEST if each != "table.py")]
)
def test_a_benchmark_runs_and_prints_finite_numbers(script, capsys, monkeypatch):
    monkeypatch.setattr(sys, "path", [str((FOLDER / script).parent), *sys.path])
    runpy.run_path(str(FOLDER / script))["main"](**SMALLEST[script])
    printed = capsys.readouterr().out
    numbers = [float(number) for number in NUMBER.findall(printed)]
    assert len(numbers) > 3, printed
    assert all(math.isfinite(number) for number in numbers), printed

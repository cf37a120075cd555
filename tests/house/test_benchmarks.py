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

NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*(?:e[-+]?\d+)?|nan|inf)(?![\w.])")


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

# SPDX-License-Identifier: MIT
"""Variants of a study a second on one core: every number varied, and one; at once, and one by one."""

import sys
import tempfile
from importlib.resources import files
from pathlib import Path

import numpy as np

import mrts
from mrts.studies.study import Study
from mrts.studies.variants import solve_one_by_one, solve_variants

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "study_cases"))
from interleaved import median_times, on_one_processor
from wide_studies import wide_study

DATA = Path(str(files("mrts") / "data"))
CELLS = {"dual_ur5": "lift_and_turn.yaml", "planar_dual_arm": "lift.yaml", "squeeze": "lift_and_turn.yaml"}
VARIANTS, ALONE, REPEATS = 2000, 5, 3
NEAR, FAR = 0.02, 0.3
"""How far poses and postures go [m, rad]: every variant can be followed, or few."""


def main(variants: int = VARIANTS, alone: int = ALONE, repeats: int = REPEATS) -> None:
    """Print a table of variants a second, by CPU time, for the shipped cells at 101 samples."""
    print(f"{'cell':<17} {'varied':<22} {'feasible':>9} {'at once [1/s]':>14} {'alone [1/s]':>12}")
    with tempfile.TemporaryDirectory() as name:
        for cell, motion in CELLS.items():
            where = DATA / cell / "cell.yaml", DATA / cell / motion
            for spread in (NEAR, FAR):
                study = wide_study(Path(name), *where, spread=spread, count=variants)
                show(cell, f"{len(study.parameters)} numbers, ±{spread:g}", study, alone, repeats)
            show(cell, "mass", one_number(Path(name), *where, variants), alone, repeats)


def one_number(folder: Path, cell: Path, motion: Path, variants: int) -> Study:
    """A study of the mass alone."""
    path = folder / "study.yaml"
    text = f"cell: {cell}\nmotion: {motion}\nvary: {{object.mass: {{from: 1, to: 3, steps: {variants}}}}}\n"
    path.write_text(text, encoding="utf-8")
    return mrts.read_study(path)


def show(cell: str, varied: str, study: Study, alone: int, repeats: int) -> None:
    """Measure one study and print its line."""
    points = study.points(0, alone)
    taken = median_times(
        {
            "at once": lambda: solve_variants(study, 0, study.variants),
            "alone": lambda: solve_one_by_one(study, points, 0),
        },
        repeats,
    )
    feasible = np.mean(np.array(solve_variants(study, 0, study.variants)["status"]) == "feasible")
    rates = study.variants / taken["at once"], alone / taken["alone"]
    print(f"{cell:<17} {varied:<22} {100 * feasible:>7.0f} % {rates[0]:>14.0f} {rates[1]:>12.0f}", flush=True)


if __name__ == "__main__":
    on_one_processor()
    main()

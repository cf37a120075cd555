# SPDX-License-Identifier: MIT
"""What becomes of plans in closed loop: three shipped cells, three profiles, 100 cells each with drawn errors.

The table of docs/simulate.md; `python benchmarks/closed_loop.py N` draws N instead.
"""

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

import mrts
from mrts.control.simulate import LIKELY, Simulation, Trials

DATA = Path(mrts.__file__).parent / "data"

CELLS = {"dual_ur5": "lift_and_turn.yaml", "three_arms": "lift_and_turn.yaml", "squeeze": "lift_and_turn.yaml"}

RATES = 10.0
"""Torque limits per second, of the smooth profile."""

ERRORS = mrts.PlantErrors(mass=0.05, com=np.full(3, 0.005))
"""Between minus and plus which errors are drawn."""

PLANS: dict[str, Callable[..., mrts.ScalingResult | mrts.RetimingResult]] = {
    "constant": mrts.scale,
    "constant, `--distribute reserve`": partial(mrts.scale, distribute="reserve"),
    "optimal": mrts.retime,
    "smooth": partial(mrts.retime, rates=RATES),
    "smooth, `--distribute least-torque`": partial(mrts.retime, rates=RATES, distribute="least-torque"),
}

HEAD = ("cell", "profile", "duration", "largest use", "95 % of trials", "worst", "keep all limits", "object")


def row(name: str, profile: str, found: Simulation, trials: Trials) -> str:
    """A line of the table."""
    moving = found.played.time <= found.plan.duration
    off = 1e3 * np.sqrt(np.mean(found.object_error[moving] ** 2))
    shares = (found.uses[0][1].share, np.percentile(trials.largest, LIKELY), np.max(trials.largest))
    told = (f"{100 * share:.0f} %" for share in shares)
    kept = f"{trials.kept} of {len(trials.errors)}"
    return " | ".join((name, profile, f"{found.plan.duration:.3f} s", *told, kept, f"{off:.2f} mm"))


def main(trials: int) -> None:
    """Print the table."""
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}")
    for name, file in CELLS.items():
        cell, motion = mrts.load_cell(DATA / name / "cell.yaml"), mrts.load_motion(DATA / name / file)
        for profile, plan in PLANS.items():
            found = mrts.simulate(plan(cell, motion), errors=ERRORS, trials=trials)
            if found.trials is not None:
                print(f"| {row(name, profile, found, found.trials)} |", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if sys.argv[1:] else 100)

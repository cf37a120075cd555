# SPDX-License-Identifier: MIT
"""Speed override beside the rule of ros2_controllers' speed scaling, on the same wishes: the table of docs/override.md.

Of the override the excess is that of the torques and wrenches that it commands, of speed scaling, which commands
positions, the least with which any torques and wrenches could follow them.
"""

from functools import partial
from pathlib import Path

import numpy as np

import mrts
from mrts.base.arrays import Array
from mrts.override.speed_override import TICK
from mrts.override.wishes import random_wishes, wanted_at_ticks
from mrts.simulation.speed_scaling import speed_scaling

DATA = Path(mrts.__file__).parent / "data"

CELLS = {"planar_dual_arm": "lift.yaml", "dual_ur5": "lift_and_turn.yaml", "three_arms": "lift_and_turn.yaml"}
PLANS = {"constant": mrts.scale, "smooth": partial(mrts.retime, rates=10.0)}

RAMP = 0.05
"""Time in which an operator turns the knob [s]."""

HEAD = ("cell", "profile", "half the speed", "down to 0.3 and up", "a stop", "random", "later by")


def wishes(duration: float) -> dict[str, Array]:
    """Half the speed; the knob turned down and up again; stopped halfway for 0.1 s; steps, ramps and stops."""
    low, high, steps = 0.4 * duration, 0.4 * duration + 0.2, np.linspace(0.0, 1.0, 51)
    down = np.column_stack([low + RAMP * steps, 1 - 0.7 * steps])
    up = np.column_stack([high + RAMP * steps, 0.3 + 0.7 * steps])
    return {
        "half the speed": np.array([[0.0, 0.5]]),
        "down to 0.3 and up": np.concatenate([[[0.0, 1.0]], down, up]),
        "a stop": np.array([[0.0, 1.0], [duration / 2, 0.0], [duration / 2 + 0.1, 1.0]]),
        "random": random_wishes(1, duration),
    }


def row(cell: str, profile: str, result: mrts.ScalingResult | mrts.RetimingResult) -> str:
    """A line of the table: by how much limits are passed at most, by the override and by speed scaling."""
    told, later, override = [], [], mrts.SpeedOverride(result)
    shown = result.retimed if isinstance(result, mrts.RetimingResult) else result
    if shown is None or shown.trajectory is None:
        raise SystemExit(result.sentence())
    for given in wishes(override.duration).values():
        wanted = wanted_at_ticks(given, override.duration, TICK)
        states = override.play(wanted, state=override.start(0.0, min(wanted[0], 1.0)))
        ticks, scaled = int(np.argmax(states["finished"])) + 1, speed_scaling(shown.trajectory, wanted, TICK)
        shares = np.max(override.excess(states[:ticks]), initial=0.0), np.max(scaled.excess)
        told.append(" / ".join(f"{100 * share:.{0 if share > 1 else 2}f} %" for share in shares))
        later.append(TICK * (ticks - len(scaled.time)))
    return " | ".join((cell, profile, *told, f"{1e3 * max(later):.0f} ms"))


def main() -> None:
    """Print the table."""
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}")
    for name, motion in CELLS.items():
        cell, given = mrts.load_cell(DATA / name / "cell.yaml"), mrts.load_motion(DATA / name / motion)
        for profile, plan in PLANS.items():
            print(f"| {row(name, profile, plan(cell, given))} |", flush=True)


if __name__ == "__main__":
    main()

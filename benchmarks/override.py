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
from mrts.control.override_tables import TICK
from mrts.control.speed_override import random_wishes, wanted_at_ticks
from mrts.following.coordinated_motion import carried_by_first
from mrts.program.infeasibility import motion_widening
from mrts.program.motion_rows import motion_rows
from mrts.scaling.scaled_trajectory import ScaledTrajectory

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


def speed_scaling(plan: ScaledTrajectory, wanted: Array, dt: float) -> Array:
    """By which share limits are passed at least at each tick where a plan's clock alone is slowed, Shape (k,).

    Source: ros2_controllers, joint_trajectory_controller.cpp, `traj_time_ += period * scaling_factor_`: at every tick
    the place on the plan goes on by the period times the wanted speed; commanded are the positions of the spline there.
    It does so where it commands positions alone, and looks at no limit. Between two ticks joints are given the velocity
    that they have along the plan at the wanted speed then, and the acceleration that leads to the next one within the
    period: no way to follow asks for less.

    Args:
        plan: The plan.
        wanted: Speed at each tick, Shape (k,); below 0 it is 0, as the controller takes it.
        dt: Between ticks [s].
    """
    speed = np.maximum(wanted, 0.0)
    place = np.minimum(dt * np.concatenate([[0.0], np.cumsum(speed)]), plan.duration)
    count = int(np.searchsorted(place, plan.duration)) + 1
    joints = plan.course()
    q, dq = joints(place[:count]), joints(place[:count], 1) * np.append(speed, speed[-1])[:count, None]
    ddq = np.diff(dq, axis=0) / dt
    motion = carried_by_first(plan.cell, dt * np.arange(len(ddq), dtype=np.float64), q[:-1], dq[:-1], ddq)
    return motion_widening(motion_rows(plan.cell, motion), np.ones(len(ddq)))


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
        shares = np.max(override.tables.excess(states[:ticks]), initial=0.0), np.max(scaled)
        told.append(" / ".join(f"{100 * share:.{0 if share > 1 else 2}f} %" for share in shares))
        later.append(TICK * (ticks - len(scaled)))
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

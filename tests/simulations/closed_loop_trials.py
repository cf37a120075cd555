"""The shipped cells with motors and limits for a trial in closed loop, and the plans that are played in it."""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from mujoco_cells import PLANAR_MOTORS, UR5_MOTORS, urdf_of
from played_plans import CLAMP, play
from random_motors import equipped

import mrts

DATA = Path(str(files("mrts") / "data"))

DRY, VISCOUS = 0.005, 0.005
"""Dry friction as a share of a joint's torque limit, and viscous friction likewise at 1 rad/s: what is left of it where
joints measure their torques. A gear's own friction, ten times as much, exceeds what the shipped contacts may bear."""

FOR_FEEDBACK = 0.1
"""Share of every torque limit that no plan uses: it is the feedback's."""

TORQUE_RATE = 11.5
"""As a multiple of a joint's torque limit a second: Franka's 1000 N m/s for 87 N m."""

FILLED = 0.024
"""Contact forces and moments rise to their limits in no less [s]: two swings of the box between two clamps."""

CONTACTS = 20.0
"""Times the limits of the planar cell's contacts. The paper's 1 N m is a hundredth of what the shoulders give, which no
controller holds that does not measure forces."""

GRASPS = {"rigid": None, "clamps": CLAMP}

MOTIONS = {
    "dual_ur5": ("lift_and_turn.yaml", UR5_MOTORS["armature"], 1.0),
    "planar_dual_arm": ("lift.yaml", PLANAR_MOTORS["armature"], CONTACTS),
}


@dataclass(frozen=True, eq=False)
class Trial:
    """A cell and a motion that is planned in four ways.

    Attributes:
        name: Of the shipped cell.
        cell: With the motors' full torques.
        planned: The same with what plans may use.
        motion: The given motion.
    """

    name: str
    cell: mrts.Cell
    planned: mrts.Cell
    motion: mrts.ObjectMotion

    @cached_property
    def constant(self):
        return mrts.scale(self.planned, self.motion)

    @cached_property
    def optimal(self):
        return mrts.retime(self.planned, self.motion)

    @cached_property
    def smooth(self):
        return mrts.retime(self.planned, self.motion, rates=True)

    @cached_property
    def as_long(self):
        """The constant factor that takes as long as the smooth plan, whether or not it keeps velocity limits."""
        c2 = (self.motion.time[-1] / self.smooth.duration) ** 2
        return mrts.scale(self.planned.without_velocity_limits(), self.motion, select=c2)

    def trajectory(self, profile):
        found = getattr(self, profile)
        return (found if isinstance(found, mrts.ScalingResult) else found.retimed).trajectory

    @lru_cache  # noqa: B019 (a trial lives as long as its run)
    def played(self, profile, grasp="rigid"):
        """One of the four plans, played with a grasp of `GRASPS`."""
        return play(self.cell, urdf_of(DATA / self.name), self.trajectory(profile), GRASPS[grasp])


@lru_cache
def trial(name, *, dry=DRY, torque_rate=TORQUE_RATE, filled=FILLED, velocity_limits=True):
    """The trial of a shipped cell; what is not said is as above."""
    motion, armature, contacts = MOTIONS[name]
    cell = mrts.load_cell(DATA / name / "cell.yaml")
    cell = cell if velocity_limits else cell.without_velocity_limits()
    held = []
    for robot in cell.robots:
        lower, upper = contacts * robot.wrench_lower, contacts * robot.wrench_upper
        rate = contact_rates(cell, upper, filled)
        held.append(replace(robot, wrench_lower=lower, wrench_upper=upper, contact_rate=rate))
    most = held[0].torque_upper
    motors = {"armature": armature, "coulomb": dry * most, "viscous": VISCOUS * most}
    real = equipped(replace(cell, robots=tuple(held)), torque_rate=torque_rate * most, **motors)
    left = 1 - FOR_FEEDBACK
    used = [replace(r, torque_lower=left * r.torque_lower, torque_upper=left * r.torque_upper) for r in real.robots]
    return Trial(name, real, replace(real, robots=tuple(used)), mrts.load_motion(DATA / name / motion))


def contact_rates(cell, upper, filled):
    """Of a hand's forces and moments: the least limit of either in that time, Shape (w,) [N/s, N m/s]."""
    forces = np.array([name.startswith("f") for name in cell.wrench_components])
    return np.where(forces, np.min(upper[forces]), np.min(upper[~forces])) / filled


def measures(played):
    """What the table of the trial has: s, shares of limits, shares of commands, mrad, mm."""
    return {
        "duration [s]": played.duration,
        "moving [%]": 100 * played.overstep,
        "after [%]": 100 * played.overstep_after,
        "cut [%]": 100 * played.cut,
        "joints [mrad]": 1e3 * played.rms(played.error),
        "object [mm]": 1e3 * played.rms(played.object_error),
        "largest [mm]": 1e3 * float(np.max(played.object_error)),
        "off path [mm]": 1e3 * played.rms(played.off_path),
    }

# SPDX-License-Identifier: MIT
"""What is drawn of a motion, whoever draws it: where everything is, in which colours, and how fast it plays."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.colours import COLOURS
from mrts.base.rigid_transform import quaternions_from_rotations
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.following.bodies import body_poses
from mrts.scaling.scaled_trajectory import ScaledTrajectory

Rgb = tuple[int, int, int]
"""0 to 255."""

OBJECT, OUTLINE = (236, 178, 60), (196, 138, 24)
"""Of the object, and of its edges at the start and the goal: seen on a light page and on a dark one."""

SURROUNDINGS, SEE_THROUGH = (140, 152, 170), 0.4
"""Of what stands around the arms, and how opaque it is: they are seen behind it."""

PATH, OVER_LIMIT = (70, 70, 80), (212, 0, 0)
"""Of the object's path where limits are kept, and of what passes or decides a limit."""

FORCE, MOMENT = (190, 50, 0), (0, 110, 80)

SHARED_BASE = (156, 163, 172)
"""Of what two arms of one machine stand on."""

PACES = {1.0: "real time", 0.5: "1/2", 0.2: "1/5", 0.1: "1/10", 0.05: "1/20", 0.02: "1/50", 0.01: "1/100"}
"""Seconds of the motion in a second of its playing, and what that is called."""

SHORTEST_PLAY = 3.0
"""A motion is played at least this long, at one of `PACES` [s]."""


ROUNDED_DOWN = 1e-9
"""A number below a round one by this share is that one: rounding of a quotient."""


def arm_hex(index: int) -> str:
    """The colour of the arm with this number, as "#0072B2"; after six they begin again."""
    return COLOURS[index % (len(COLOURS) - 1)]


def arm_colour(index: int) -> Rgb:
    """The colour of `arm_hex` as numbers."""
    colour = arm_hex(index)
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:], 16)


def rgba(colour: Rgb, opacity: float = 1.0) -> tuple[float, float, float, float]:
    """The colour with shares from 0 to 1."""
    red, green, blue = (part / 255 for part in colour)
    return red, green, blue, opacity


def round_down(value: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is not above a value > 0, but for rounding."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(digit for digit in (1, 2, 5, 10) if digit <= value / power * (1 + ROUNDED_DOWN)) * power)


def suited_pace(duration: float) -> float:
    """The fastest of `PACES` at which a motion of some duration [s] plays for `SHORTEST_PLAY`."""
    return next((pace for pace in PACES if duration >= SHORTEST_PLAY * pace), min(PACES))


@dataclass(frozen=True, eq=False)
class Scene:
    """Arms, object and forces along a motion, at k samples.

    Attributes:
        time: Shape (k,) [s].
        q: Joint positions, Shape (k, m) [rad or m].
        position, rotation: Of the object, Shape (k, 3) [m] and (k, 3, 3).
        passed: Where a limit is passed, or an arm does not reach, Shape (k,).
        wrench: Of all arms on the object, each in its base axes and the cell's components, Shape (k, n w) [N, N m];
            None where nothing is known of it.
    """

    cell: Cell
    time: Array
    q: Array
    position: Array
    rotation: Array
    passed: NDArray[np.bool_]
    wrench: Array | None = None

    @classmethod
    def of(cls, done: ScaledTrajectory, passed: NDArray[np.bool_] | None = None) -> "Scene":
        """A motion at its samples."""
        carried = done.motion.object
        nowhere = np.zeros(len(done.time), dtype=bool) if passed is None else passed
        return cls(done.cell, done.time, done.q, carried.position, carried.rotation, nowhere, done.wrench)

    def at(self, samples: NDArray[np.integer]) -> "Scene":
        """At some of its samples."""
        names = ("time", "q", "position", "rotation", "passed", *(["wrench"] if self.wrench is not None else []))
        return replace(self, **{name: getattr(self, name)[samples] for name in names})

    @cached_property
    def bodies(self) -> tuple[tuple[Array, Array], ...]:
        """By arm, where its bodies are: Shape (k, n_i + 1, 3, 3), and Shape (k, n_i + 1, 3) [m]."""
        return tuple(
            body_poses(robot, self.q[:, joints])
            for robot, joints in zip(self.cell.robots, self.cell.joint_slices.values(), strict=True)
        )

    @cached_property
    def lines(self) -> tuple[Array, ...]:
        """By arm, a line through its base, its joints and its tip, Shape (k, n_i + 2, 3) [m]."""
        return tuple(arm_line(robot, *body) for robot, body in zip(self.cell.robots, self.bodies, strict=True))

    @cached_property
    def contacts(self) -> tuple[Array, Array, Array]:
        """Where each arm holds the object [m], its forces [N] and moments [N m] on it, world, Shape (k, n, 3) each."""
        cell, samples = self.cell, len(self.time)
        six = np.zeros((samples, len(cell.robots), 6))
        if self.wrench is not None:
            six[..., cell.wrench_rows] = self.wrench.reshape(samples, len(cell.robots), -1)
        bases = np.array([robot.T_world_base.R for robot in cell.robots])
        tips = np.array([robot.T_object_tip.p for robot in cell.robots])
        force, moment = (np.einsum("rij,krj->kri", bases, part) for part in (six[..., :3], six[..., 3:]))
        return self.position[:, None] + np.einsum("kij,rj->kri", self.rotation, tips), force, moment

    @property
    def strongest(self) -> tuple[float, float]:
        """The largest force [N] and moment [N m] of one arm on the object."""
        force, moment = (float(np.max(np.linalg.norm(each, axis=-1))) for each in self.contacts[1:])
        return force, moment

    def place(self, time: float) -> float:
        """Where a time [s] is among the samples, or between two; before the start and after the end at it."""
        return float(np.interp(time, self.time, np.arange(len(self.time))))


def arm_line(robot: Robot, R: Array, p: Array) -> Array:
    """Base, a point on each joint axis, and tip of an arm, Shape (N, n_i + 2, 3) [m], with bodies of `body_poses`."""
    # a joint's point moves with the body that it carries
    points = p + np.einsum("kbij,bj->kbi", R, np.concatenate([np.zeros((1, 3)), robot.points]))
    tip = p[:, -1:] + np.einsum("kbij,j->kbi", R[:, -1:], robot.T_base_tip.p)
    return np.concatenate([points, tip], axis=1)


def wxyz(R: Array) -> Array:
    """Rotations, Shape (…, 3, 3), as quaternions of viser and MuJoCo, w first, Shape (…, 4)."""
    return np.roll(quaternions_from_rotations(R), 1, axis=-1)


def blended(values: Array, place: float) -> Array:
    """Values of all samples, Shape (k, …), at one of them, or linear between two.

    Every point of a body is then on the line between where it is at both, so that hands stay at their grasps; rotations
    are so only to the square of the step.
    """
    first = min(int(place), len(values) - 1)
    share = place - first
    here: Array = values[first]
    return here if share == 0 else here + share * (values[first + 1] - here)

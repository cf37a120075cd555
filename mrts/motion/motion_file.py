# SPDX-License-Identifier: MIT
"""The motion file: a pose to a pose, waypoints, or a table of object or joint motion; tables and bags by themselves."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from mrts.base.errors import InputError, as_path
from mrts.base.formats.record import Pose, Record, Rule
from mrts.base.input_file import plain
from mrts.motion.csv_motion import MAX_SAMPLES, read_table
from mrts.motion.joint_table import JointTable
from mrts.motion.object_courses import PROFILES, ProfiledPath, geodesic_rates, waypoint_rates
from mrts.motion.object_motion import SHORTEST_STEP, ObjectMotion
from mrts.motion.ros_messages import is_bag, read_joint_trajectories

MIN_SAMPLES = 11
"""Limits are checked at the samples only: a range from fewer says little about the motion between them."""

DEFAULT_SAMPLES = 101

LONGEST_DURATION = 1e9
"""[s]; in thirty years no robot moves."""

Duration = Annotated[float, Rule(gt=SHORTEST_STEP, le=LONGEST_DURATION)]
"""[s]."""

KINDS = {
    "start": {"start", "end", "duration", "profile"},
    "waypoints": {"waypoints", "duration", "profile"},
    "file": {"file"},
    "joints": {"joints"},
}
"""The four kinds of motion, by the key that chooses one, and the keys that each needs."""

VALUES = {"profile": " (sinusoid, trapezoid, cubic or quintic)", "duration": " (in s)"}
"""What is told of a key that is missing."""

MOST_TRAJECTORIES = 100_000
"""Of a bag."""


class MotionDescription(Record):
    """A validated motion file; see docs/cell_file.md.

    Attributes:
        duration: t_f [s]; of a path, a table has its own times.
        samples: Number of samples, both ends included; a table with derivatives keeps its own.
        profile: Velocity profile along a path.
        start: Object frame in the world at t = 0.
        end: Object frame in the world at t = t_f.
        waypoints: Object frames in the world that the path goes through.
        file: CSV table of the object's motion, relative to the motion file.
        joints: CSV table or ROS 2 bag of the joints' motion, relative to the motion file.
        trajectory: Of those of a topic of the bag, which one is read, from 0.

    Raises:
        InputError: If a value breaks a rule.
    """

    duration: Duration | None = None
    samples: Annotated[int, Rule(ge=MIN_SAMPLES, le=MAX_SAMPLES)] | None = None
    profile: Literal["sinusoid", "trapezoid", "cubic", "quintic"] | None = None
    start: Pose | None = None
    end: Pose | None = None
    waypoints: Annotated[list[Pose], Rule(min_length=2)] | None = None
    file: str | None = None
    joints: str | None = None
    trajectory: Annotated[int, Rule(ge=0, le=MOST_TRAJECTORIES)] | None = None

    def problem(self) -> str:
        """The rule that keys break with each other; empty if none."""
        given = {key for key, value in self if value is not None} - {"samples"}
        chosen = [kind for kind in KINDS if kind in given or (kind == "start" and "end" in given)]
        if len(chosen) != 1:
            here = f"here are {', '.join(chosen)}" if chosen else "here is none of them"
            return f"a motion is given by one of: start and end, waypoints, file, joints; {here}"
        needed = KINDS[chosen[0]]
        if missing := needed - given:
            told = [f"{key}{VALUES.get(key, '')}" for key in sorted(missing)]
            return f"this key is required with '{chosen[0]}': {', '.join(told)}"
        if extra := given - needed - ({"trajectory"} if chosen[0] == "joints" else set()):
            return f"'{chosen[0]}' does not go with: {', '.join(sorted(extra))}"
        return ""


def load_motion(motion: Path | str | Mapping[str, Any], *, smooth: float | None = None) -> ObjectMotion | JointTable:
    """Read a motion.

    Args:
        motion: A motion file (YAML), a CSV table of the object's or the joints' motion, or a ROS 2 bag with joint
            trajectories (a folder, or an .mcap file by itself; needs the extra 'ros'); or what a motion file says, as a
            dictionary, whose files are relative to the working folder.
        smooth: Of noisy recordings of joints: how far a smooth spline may be from any position [rad or m]
            (`JointTable.smoothed`); None leaves them as they are.

    Returns:
        Samples of the object's motion, or a table of joint motion, which needs a cell to say where the object is.

    Raises:
        InputError: If the file or a table that it names is missing, malformed, or breaks a rule, or cannot be smoothed.
    """
    found = _read(motion)
    if smooth is None:
        return found
    if not isinstance(found, JointTable):
        raise InputError("smooth", "is of recorded joints, and this is a motion of the object.", value=smooth)
    return found.smoothed(smooth)


def _read(motion: Path | str | Mapping[str, Any]) -> ObjectMotion | JointTable:
    if isinstance(motion, Mapping):
        path = Path("motion")
        description = MotionDescription.read(path, plain("motion", motion), "motion file")
    else:
        path = as_path("motion", motion)
        if is_bag(path):
            return read_joint_trajectories(path, None)
        if path.suffix.lower() == ".csv":
            return read_table(path, None)
        description = MotionDescription.read_file(path, "motion file")
    if description.file is not None:
        return read_table(path.parent / description.file, description.samples)
    if description.joints is not None:
        joints = path.parent / description.joints
        if is_bag(joints):
            return read_joint_trajectories(joints, description.samples, description.trajectory)
        if description.trajectory is not None:
            raise InputError(path, f"is of a ROS 2 bag, but {description.joints} is none.", key="trajectory")
        return read_table(joints, description.samples)
    try:
        return _sampled(description)
    except InputError as error:
        raise InputError(path, error.rule, key=error.where) from None


def described_motion(path: Path | str) -> MotionDescription | None:
    """The description of a motion from pose to pose or through waypoints; None of a table or a bag.

    Raises:
        InputError: If a motion file breaks a rule.
    """
    path = as_path("path", path)
    if is_bag(path) or path.suffix.lower() == ".csv":
        return None
    description = MotionDescription.read_file(path, "motion file")
    return description if description.profile is not None else None


def _sampled(description: MotionDescription) -> ObjectMotion:
    """Samples of a motion from pose to pose or through waypoints, evenly spaced in time."""
    assert description.profile is not None and description.duration is not None  # noqa: S101, PT018 (no table)
    poses = description.waypoints or [description.start or Pose(), description.end or Pose()]
    through = np.array([pose.xyz for pose in poses]), np.array([pose.rotation() for pose in poses])
    rates = (waypoint_rates if description.waypoints else geodesic_rates)(*through)
    path = ProfiledPath(rates, PROFILES[description.profile], description.duration)
    time = np.linspace(0.0, 1.0, description.samples or DEFAULT_SAMPLES) * description.duration
    names = [f"waypoints[{index}]" for index in range(len(poses))] if description.waypoints else ["start", "end"]
    written = tuple(
        remark
        for name, pose in zip(names, poses, strict=True)
        for remark in pose.degrees_remarks(f"the motion's {name}")
    )
    return ObjectMotion(time, *path(time), remarks=written, course=path)

# SPDX-License-Identifier: MIT
"""The motion of the carried object: the motion file and its samples."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from scipy.spatial.transform import Rotation

from mrts.errors import InputError
from mrts.input_file import Pose, Positive, StrictModel, read_model
from mrts.rigid_transform import Array, rotation_from_rpy
from mrts.velocity_profile import PROFILES

MAX_SAMPLES = 1_000_000


class MotionDescription(StrictModel):
    """A validated motion file.

    Attributes:
        duration: t_f [s].
        samples: Number of samples, both ends included.
        profile: Velocity profile.
        start: Object frame in the world at t = 0.
        end: Object frame in the world at t = t_f.
    """

    duration: Positive
    samples: Annotated[int, Field(ge=2, le=MAX_SAMPLES)] = 101
    profile: Literal["sinusoid", "trapezoid", "cubic", "quintic"]
    start: Pose
    end: Pose


@dataclass(frozen=True)
class ObjectMotion:
    """N samples of the given motion of the object frame, world axes.

    Attributes:
        time: Shape (N,) [s], strictly increasing from 0.
        position: p, Shape (N, 3) [m].
        rotation: R_world_object, Shape (N, 3, 3).
        twist: [p'; φ'], Shape (N, 6) [m/s, rad/s].
        acceleration: [p''; φ''], Shape (N, 6) [m/s², rad/s²].
    """

    time: Array
    position: Array
    rotation: Array
    twist: Array
    acceleration: Array

    def __post_init__(self) -> None:
        samples = np.shape(self.time)[0] if np.ndim(self.time) == 1 else 0
        shapes = {"position": (3,), "rotation": (3, 3), "twist": (6,), "acceleration": (6,)}
        if samples < 2 or self.time[0] != 0 or not np.all(np.diff(self.time) > 0):  # noqa: PLR2004 (two ends)
            raise InputError("time", "must have Shape (N,) with N >= 2, start at 0 and strictly increase.")
        for name, shape in shapes.items():
            value = getattr(self, name)
            if np.shape(value) != (samples, *shape) or not np.all(np.isfinite(value)):
                raise InputError(name, f"must have Shape {(samples, *shape)} and be finite.")


def load_motion(path: Path | str) -> ObjectMotion:
    """Read a motion file and sample it.

    Raises:
        InputError: If the file is missing, not YAML, or breaks a rule.
    """
    return sample_motion(read_model(Path(path), MotionDescription, "motion file"))


def sample_motion(description: MotionDescription) -> ObjectMotion:
    """Samples along a straight line and the geodesic rotation, under the velocity profile."""
    start, end, duration = description.start, description.end, description.duration
    u = np.linspace(0.0, 1.0, description.samples)
    s, ds, dds = PROFILES[description.profile](u)
    ds, dds = ds / duration, dds / duration**2

    p0 = np.array(start.xyz)
    step = np.array(end.xyz) - p0
    R0, R1 = rotation_from_rpy(*start.rpy), rotation_from_rpy(*end.rpy)
    turn = Rotation.from_matrix(R1 @ R0.T).as_rotvec()  # world axes, constant along the geodesic
    rotation = Rotation.from_rotvec(s[:, None] * turn).as_matrix() @ R0
    direction = np.concatenate([step, turn])
    return ObjectMotion(
        u * duration,
        p0 + s[:, None] * step,
        rotation,
        ds[:, None] * direction,
        dds[:, None] * direction,
    )

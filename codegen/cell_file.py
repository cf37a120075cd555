# SPDX-License-Identifier: MIT
"""The cell file: n arms, their bases and grasps, the object, the limits."""

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from mrts_codegen.hand_file import MOST_CONTACTS, ContactDescription
from mrts_codegen.joint_limits import joint_limits_reference
from mrts_codegen.motors_block import MotorsDescription
from mrts_codegen.object_shape import ObstacleDescription, ShapeDescription
from mrts_codegen.urdf_reference import FileReference, mesh_reference

from mrts.base.arrays import Array
from mrts.base.formats.pose import Angle, Finite, GraspPose, Name, Pose, Positive, Vector3
from mrts.base.formats.record import Record, Rule
from mrts.base.input_file import plain, read_model, validated
from mrts.base.load_box import PARAMETERS, range_problem
from mrts.base.manifest import MOST
from mrts.cell.hands import Bounds
from mrts.cell.motors import Accelerations, TorqueLimits, Velocities
from mrts.cell.points import CarriedThing, LinkPointLimit, ObjectRates, PointLimit

INERTIA_TOLERANCE = 1e-9
"""Share by which an inertia may miss symmetry, the triangle inequality, and 0: printed with few digits."""

ROBOT_NAMES_TAKEN = frozenset({"time", "components", "object"})
"""Keys that stand beside the robots' names in results, and what limits of the object are told as."""


MOST_POINTS = 100
"""Limited points of an arm or the object, things on it."""

Range = Annotated[list[Finite], Rule(min_length=2, max_length=2)]
"""Least and largest value."""


class VariationDescription(Record):
    """Ranges of what is uncertain of the load; see docs/uncertain_load.md.

    Attributes:
        mass, ixx, iyy, izz: Factors of the mass and of the principal moments.
        mx, my, mz: First moments [kg m].
        com_x, com_y, com_z: Offsets of the com [m], with `hull: outer`.
        hull: How offsets are made linear.
    """

    mass: Range | None = None
    ixx: Range | None = None
    iyy: Range | None = None
    izz: Range | None = None
    mx: Range | None = None
    my: Range | None = None
    mz: Range | None = None
    com_x: Range | None = None
    com_y: Range | None = None
    com_z: Range | None = None
    hull: Literal["outer"] | None = None

    def ranges(self) -> dict[str, tuple[float, float]]:
        """The ranges that are given, by parameter."""
        return {name: (given[0], given[1]) for name in PARAMETERS if (given := getattr(self, name)) is not None}

    def problem(self) -> str:
        """The rule that its ranges break; empty if none."""
        return range_problem(self.ranges(), outer_hull=self.hull is not None)


class ObjectDescription(Record):
    """The carried object.

    Attributes:
        mass: [kg].
        inertia: At the com in the object frame: principal moments, Shape (3,), or matrix, Shape (3, 3) [kg m²]; None is
            that of a uniform body of its shape.
        shape: What it looks like.
        variation: What is uncertain of it.
        velocity: How fast it may move.
        acceleration: How fast that may change.
        frames: Points of it whose motion is limited.
        carries: Things that stand loose on it.
    """

    mass: Positive
    inertia: Annotated[list[Finite | Vector3], Rule(min_length=3, max_length=3)] | None = None
    shape: ShapeDescription | None = None
    variation: VariationDescription | None = None
    velocity: ObjectRates = ObjectRates()
    acceleration: ObjectRates = ObjectRates()
    frames: Annotated[list[PointLimit], Rule(max_length=MOST_POINTS)] = []  # noqa: RUF012 (each record has its own copies)
    carries: Annotated[list[CarriedThing], Rule(max_length=MOST_POINTS)] = []  # noqa: RUF012

    def inertia_matrix(self) -> Array | None:
        """Inertia at the com in the object frame, Shape (3, 3) [kg m²]; None where it is that of its shape."""
        if self.inertia is None:
            return None
        inertia = np.array(self.inertia, dtype=float)
        return inertia if inertia.ndim == 2 else np.diag(inertia)  # noqa: PLR2004 (a matrix)

    def problem(self) -> str:
        """The rule that its inertia breaks; empty if none."""
        if len({isinstance(entry, list) for entry in self.inertia or ()}) > 1:
            return "its inertia must be three moments or three rows of three values"
        inertia = self.inertia_matrix()
        if inertia is None:
            needed = "its 'inertia' is required, or its 'shape', from which that of a uniform body follows"
            return needed if self.shape is None else ""
        problem = inertia_problem(inertia)
        return problem and f"its inertia {problem}"


class RobotDescription(Record):
    """One arm of the cell; see docs/cell_file.md for every key."""

    name: Name
    urdf: Annotated[str, Rule(min_length=1)]
    base_link: str | None = None
    tip_link: str
    base: Pose = Pose()
    grasp: GraspPose = GraspPose()
    posture: Annotated[list[Angle], Rule(min_length=1)]
    torque: TorqueLimits | None = None
    joint_limits: Annotated[str, Rule(min_length=1)] | None = None
    velocity: Velocities | None = None
    acceleration: Accelerations | None = None
    frames: Annotated[list[LinkPointLimit], Rule(max_length=MOST_POINTS)] = []  # noqa: RUF012
    wrench: Bounds = Bounds()
    contact_rate: Annotated[list[Positive | None], Rule(min_length=2, max_length=2)] | None = None
    contact: Annotated[list[ContactDescription], Rule(max_length=MOST_CONTACTS)] = []  # noqa: RUF012
    fixed: dict[str, Angle] = {}  # noqa: RUF012 (each record has its own copies)
    motors: MotorsDescription = MotorsDescription()

    def reference(self, key: str) -> FileReference:
        """What it says of its URDF."""
        return FileReference(self.urdf, key=key)


class CellDescription(Record):
    """A validated cell file."""

    name: Name
    gravity: Vector3
    plane: Literal["xy", "xz", "yz"] | None = None
    power: Positive | None = None
    inertia: Literal["strict", "lenient"] = "strict"
    object: ObjectDescription
    surroundings: Annotated[list[ObstacleDescription], Rule(max_length=MOST)] = []  # noqa: RUF012
    robots: Annotated[list[RobotDescription], Rule(min_length=1)]

    @property
    def references(self) -> list[FileReference]:
        """What it says of all files that it names."""
        limits = [joint_limits_reference(robot.joint_limits) for robot in self.robots if robot.joint_limits]
        shape = self.object.shape
        meshes = [mesh_reference(shape.mesh)] if shape is not None and shape.mesh is not None else []
        around = [mesh_reference(of.mesh, f"surroundings[{at}]") for at, of in enumerate(self.surroundings) if of.mesh]
        return [*self.urdf_references, *meshes, *limits, *around]

    @property
    def urdf_references(self) -> list[FileReference]:
        """What it says of the URDF of each robot."""
        return [robot.reference(f"robots[{index}] ({robot.name}).urdf") for index, robot in enumerate(self.robots)]

    def problem(self) -> str:
        """The rule that its robots' names break; empty if none."""
        names = [robot.name for robot in self.robots]
        for name in names:
            if names.count(name) > 1:
                return f"two robots are called '{name}'; each needs a name of its own"
            if name in ROBOT_NAMES_TAKEN:
                return f"a robot cannot be called '{name}': results use that name"
        return ""


def read_cell_description(path: Path) -> CellDescription:
    """Read and validate a cell file."""
    return read_model(path, CellDescription, "cell file")


def cell_description(data: object, where: str) -> CellDescription:
    """A dictionary made in Python, validated as a cell file; numpy's numbers as well."""
    return validated(Path(where), plain(where, data), CellDescription, where)


def inertia_problem(inertia: Array, *, triangle: float = INERTIA_TOLERANCE, rods: bool = False) -> str:
    """Why an inertia matrix, Shape (3, 3) [kg m²], is not that of a body; empty if it is.

    A body's inertia is symmetric and positive definite, and no principal moment exceeds the sum of the others.

    Args:
        inertia: At the com.
        triangle: Share by which the largest moment may exceed that sum.
        rods: Whether the least moment may be 0, as that of a rod without thickness.
    """
    if not np.all(np.isfinite(inertia)):
        return "holds a value that is not a finite number."
    scale = float(np.max(np.abs(inertia)))
    if np.max(np.abs(inertia - inertia.T)) > INERTIA_TOLERANCE * scale:
        return "is not symmetric; give ixy = iyx, ixz = izx, iyz = izy."
    moments = np.linalg.eigvalsh(inertia)
    shown = ", ".join(f"{moment:.6g}" for moment in moments)
    if moments[0] < -INERTIA_TOLERANCE * scale or (moments[0] <= 0 and not rods):
        return f"is not positive definite: its principal moments are {shown} kg m². All must be > 0."
    if triangle_excess(inertia) > triangle:
        return (
            f"breaks the triangle inequality: its principal moments are {shown} kg m², and no body has one "
            "larger than the sum of the other two."
        )
    return ""


def triangle_excess(inertia: Array) -> float:
    """Share by which the largest principal moment exceeds the sum of the others; negative if it does not."""
    least, middle, largest = np.linalg.eigvalsh(inertia)
    total = float(least + middle)
    return float(largest) / total - 1 if total > 0 else np.inf

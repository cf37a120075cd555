# SPDX-License-Identifier: MIT
"""manifest.json: all that the run time knows of a cell beside its compiled functions."""

import hashlib
import json
import re
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from mrts.base.errors import InputError
from mrts.base.formats.broken_record import BrokenRecordError, broken_record
from mrts.base.formats.pose import Name, Positive
from mrts.base.formats.record import Record, Rule, read_json
from mrts.base.input_file import IDENTIFIER, read_text

MANIFEST_NAME, CHAINS_NAME = "manifest.json", "chains.json"
GEOMETRY = "geometry"
"""Name of the last input of functions that hold no numbers of a cell file."""

FORMAT = 10
"""Version of this file's layout; a change that old code cannot read raises it."""

WRENCH_COMPONENTS = ("fx", "fy", "fz", "nx", "ny", "nz")
"""Names of a six-component wrench, forces before moments; a planar cell uses three of them."""

WRENCH_UNITS = dict(zip(WRENCH_COMPONENTS, ("N", "N", "N", "N m", "N m", "N m"), strict=True))
"""Unit of each component: of a force, or of a moment."""

LOAD_ENTRIES = ("mass", "mx", "my", "mz", "ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Layout of a load vector, in the object frame: mass [kg], first moments mass × com [kg m], and the inertia about the
frame's origin, which is the nominal com [kg m²]. The balance of the object is linear in it."""

GRAVITY_SIZE, ROBOT_SIZE = 3, 24
"""Layout of a geometry vector: gravity in the world [m/s²]; of each robot the rotation of its base in the world by
rows, its position [m], and those of its tip in the object frame; then `held_numbers` of all (`RobotRecord`)."""

ALWAYS_GENERATED = ("kinematics", "bias_acceleration", "dynamics", "terms", "wrench_form", "fixed_distribution")
"""Functions that every cell has."""

FOR_REDUNDANT_ARMS = ("geometric_stiffness", "geometric_stiffness_rate")
"""Functions that a cell has besides if an arm has more joints than wrench components."""

OF_MOTION = ("kinematics", "bias_acceleration", *FOR_REDUNDANT_ARMS)
"""Those that the motion of the joints takes, without forces."""

MOST = 1000
"""Robots of a cell, joints of a robot, arguments of a function: far above any that can be generated."""

LARGEST_SIZE = 100_000
"""Rows or columns of an argument, likewise."""

Matrix = list[list[float]]
Vector3 = Annotated[list[float], Rule(min_length=3, max_length=3)]
Matrix3 = Annotated[list[Vector3], Rule(min_length=3, max_length=3)]
Identifier = Annotated[str, Rule(pattern=IDENTIFIER, max_length=100)]
Size = Annotated[int, Rule(ge=1, le=LARGEST_SIZE)]


def geometry_size(robots: int, held: int) -> int:
    """Entries of a geometry vector.

    Args:
        robots: Number of them.
        held: Numbers of all their `held_numbers`.
    """
    return GRAVITY_SIZE + ROBOT_SIZE * robots + held


class JointRecord(Record):
    """One joint; axis and a point on it in base axes with every joint at zero; None is unbounded.

    It carries a mass up to the next joint, 0 where the URDF gives none [kg], of links some of which may be points: they
    have a mass but no inertia in the URDF.
    """

    name: str
    type: Literal["revolute", "prismatic"]
    axis: Vector3
    point: Vector3
    lower: float | None
    upper: float | None
    velocity: float | None
    torque_lower: float
    torque_upper: float
    carried_mass: float
    point_links: list[str]


class MotorsRecord(Record):
    """Motors of one arm, one value a joint (`joint_motors.JointMotors`); None is unbounded, or no curve."""

    armature: list[float]
    coulomb: list[float]
    viscous: list[float]
    torque_speed: list[list[Annotated[list[float], Rule(min_length=2, max_length=2)]] | None]
    torque_rate: list[float | None]
    jerk: list[float | None]
    rated: list[float | None]


class PoseRecord(Record):
    """A rigid transform: rotation matrix and position [m]."""

    rotation: Matrix3
    position: Vector3


class ContactRecord(Record):
    """Rows lower <= A F <= upper of one contact, as `contact.Contact`; None is unbounded, or not given."""

    name: str
    frame: Literal["tip", "object", "base"]
    rows: Annotated[list[str], Rule(min_length=1, max_length=LARGEST_SIZE)]
    units: list[str]
    A: Matrix
    lower: list[float | None]
    upper: list[float | None]
    given: dict[str, Any] | None


class RobotRecord(Record):
    """One arm of the cell."""

    name: Name
    urdf: str
    xacro_args: dict[str, str]
    urdf_sha256: str
    base_link: str
    tip_link: str
    joints: Annotated[list[JointRecord], Rule(min_length=1, max_length=MOST)]
    held: dict[str, float]
    held_numbers: Annotated[list[float], Rule(max_length=LARGEST_SIZE)]
    base_tip: PoseRecord
    world_base: PoseRecord
    base_root: PoseRecord
    object_tip: PoseRecord
    posture: list[float]
    wrench_lower: list[float | None]
    wrench_upper: list[float | None]
    contact_rate: list[float | None]
    motors: MotorsRecord
    torque_from_urdf: bool
    friction_from_urdf: bool
    contacts: Annotated[list[ContactRecord], Rule(max_length=MOST)]

    def problem(self) -> str:
        """The rule that sizes break; empty if none."""
        if len(self.posture) != len(self.joints):
            return "its posture must hold one position a joint"
        if any(len(getattr(self.motors, name)) != len(self.joints) for name in MotorsRecord.model_fields):
            return "its motors must hold one value a joint"
        return ""


class ArgumentRecord(Record):
    """Name and dense shape (rows, columns) of one input or output."""

    name: Identifier
    shape: tuple[Size, Size]


class FunctionRecord(Record):
    """One generated function."""

    symbol: Identifier
    instructions: Annotated[int, Rule(ge=0)]
    inputs: Annotated[list[ArgumentRecord], Rule(min_length=1, max_length=MOST)]
    outputs: Annotated[list[ArgumentRecord], Rule(min_length=1, max_length=MOST)]

    @property
    def signature(self) -> str:
        """Names and shapes of what goes in and comes out, as the C has them too."""
        given, found = (
            ", ".join(f"{item.name}[{item.shape[0]}x{item.shape[1]}]" for item in side)
            for side in (self.inputs, self.outputs)
        )
        return f"{given} -> {found}"


class CylinderRecord(Record):
    """A cylinder about the z axis of its frame, its middle at the origin [m]."""

    radius: Positive
    length: Positive


class MeshRecord(Record):
    """A surface from a file: what of it is drawn, and the hash of the file's bytes.

    Attributes:
        file: As the cell file gives it.
        scale: Metres of one unit of the file.
        sha256: Of the file's bytes.
        vertices: Of the surface that is drawn, in the shape's frame [m] (`mrts.base.formats.surface_text`).
        triangles: Likewise.
    """

    file: str
    scale: Positive
    sha256: Annotated[str, Rule(pattern="^[0-9a-f]{64}$")]
    vertices: str
    triangles: str

    def problem(self) -> str:
        """The rule that its surface breaks; empty if none."""
        from mrts.base.formats.surface_text import unpacked_surface  # noqa: PLC0415 (numpy, for cells with a mesh)

        try:
            unpacked_surface(self.vertices, self.triangles)
        except ValueError as error:
            return f"its surface {error}"
        return ""


class ShapeRecord(Record):
    """What the object looks like: a box, a cylinder or a mesh.

    Attributes:
        box: Sides along the axes of its frame, its middle at the origin, Shape (3,) [m].
        cylinder: A cylinder.
        mesh: A mesh.
        pose: The shape's frame in the object frame.
    """

    box: Annotated[list[Positive], Rule(min_length=3, max_length=3)] | None
    cylinder: CylinderRecord | None
    mesh: MeshRecord | None
    pose: PoseRecord

    def problem(self) -> str:
        """The rule that its kinds break; empty if none."""
        given = [kind for kind in (self.box, self.cylinder, self.mesh) if kind is not None]
        return "" if len(given) == 1 else "it must be one of box, cylinder, mesh"


class ObjectRecord(Record):
    """Nominal load: kg, and kg m² at the com in the object frame; ranges of what may vary (docs/uncertain_load.md).

    Velocity limits are in m/s and rad/s, None is unbounded; a shape of None is not known.
    """

    mass: Annotated[float, Rule(gt=0)]
    inertia: Matrix3
    variation: dict[str, tuple[float, float]]
    outer_hull: bool
    linear_velocity: float | None
    angular_velocity: float | None
    shape: ShapeRecord | None


class RemarkRecord(Record):
    """What to know of the files that the cell was made from, as `mrts.base.remark.Remark`."""

    code: str
    text: str
    severity: Literal["hint", "warning", "assumption"]


class ChainsRecord(Record):
    """The generated functions: what of them is the same for all cells with the same chains.

    Anyone may have written it: what of it reaches C text or a path is an identifier.
    """

    chains: Annotated[str, Rule(pattern="^[0-9a-f]{64}$")]
    casadi_version: str
    source: str
    source_sha256: str
    functions: dict[Identifier, FunctionRecord]

    needed = tuple(ALWAYS_GENERATED)

    @property
    def is_baked(self) -> bool:
        """Whether the functions hold the geometry of one cell as numbers; else it is their last input."""
        return all(one.name != GEOMETRY for function in self.functions.values() for one in function.inputs)

    def problem(self) -> str:
        """The rule that names break; empty if none."""
        stem = self.source.removesuffix(".c")
        if self.source == stem or not re.fullmatch(IDENTIFIER, stem):
            return "its source must be the name of a C file: letters, digits, single underscores, and .c"
        for short, function in self.functions.items():
            if function.symbol != f"{stem}_{short}":
                return f"the symbol of function '{short}' must be the name of the C file, _ and '{short}'"
        for short in self.needed:
            if short not in self.functions:
                return f"its functions must include '{short}'"
        return ""

    def to_json(self) -> str:
        """Deterministic text of the file."""
        return json.dumps(self.model_dump(), indent=1, allow_nan=False) + "\n"


class Manifest(ChainsRecord):
    """The whole manifest; see docs/generated_files.md. Sizes agree with each other."""

    notice: str
    content_sha256: str
    format: int
    mrts_version: str
    name: Name
    plane: Literal["xy", "xz", "yz"] | None
    wrench_components: list[Literal["fx", "fy", "fz", "nx", "ny", "nz"]]
    gravity: Vector3
    object: ObjectRecord
    robots: Annotated[list[RobotRecord], Rule(min_length=1, max_length=MOST)]
    machines: Annotated[list[tuple[str, str]], Rule(max_length=MOST)]
    remarks: Annotated[list[RemarkRecord], Rule(max_length=MOST)]

    def problem(self) -> str:
        """The rule that names or sizes break; empty if none."""
        return super().problem() or self._problem_of_names() or self._problem_of_sizes()

    def _problem_of_names(self) -> str:
        if len({robot.name for robot in self.robots}) < len(self.robots):
            return "two robots have the same name"
        return ""

    def _problem_of_sizes(self) -> str:
        size = len(self.wrench_components)
        if size != (len(WRENCH_COMPONENTS) if self.plane is None else 3) or len({*self.wrench_components}) < size:
            return "its wrench components must be three for a plane, else all six"
        for robot in self.robots:
            if {len(robot.wrench_lower), len(robot.wrench_upper), len(robot.contact_rate)} != {size}:
                return f"the wrench limits of robot '{robot.name}' must be one a wrench component"
            missing = [short for short in FOR_REDUNDANT_ARMS if short not in self.functions]
            if len(robot.joints) > size and missing:
                return f"its functions must include '{missing[0]}'"
        return ""

    def content_hash(self) -> str:
        """Hash of everything in the manifest but the hash itself."""
        content = self.model_dump(exclude={"content_sha256"})
        return hashlib.sha256(json.dumps(content, allow_nan=False).encode()).hexdigest()

    def sealed(self) -> Self:
        """The same manifest with its own hash filled in."""
        return self.model_copy(update={"content_sha256": self.content_hash()})


class MotionRecord(ChainsRecord):
    """Functions of the motion of the joints alone: of a cell for which no C was generated."""

    needed = tuple(OF_MOTION[:2])


class MotionManifest(Manifest):
    """The manifest of such a cell."""

    needed = MotionRecord.needed


def read_generated(folder: Path) -> tuple[Manifest, Path]:
    """Read a folder that `mrts generate` wrote.

    Args:
        folder: It holds manifest.json and the C file that the manifest names.

    Returns:
        The manifest and the path of the C file.

    Raises:
        InputError: If a file is missing, of another format version, or was edited by hand.
    """
    path = folder / MANIFEST_NAME
    manifest = verified_manifest(path, read_text(path, "manifest"))
    source = folder / manifest.source
    check_source(source, manifest, read_text(source, "generated C file"))
    return manifest, source


def verified_manifest(where: Path | str, text: str) -> Manifest:
    """A manifest from its text.

    Args:
        where: The file, or what else the text is from, for messages.
        text: JSON.

    Raises:
        InputError: If it is no manifest, of another format version, or was edited by hand.
    """
    try:
        data = read_json(text)
        _check_format(where, data)
        manifest = Manifest.model_validate(data)
    except BrokenRecordError as error:
        broken = broken_record(where, error)
        rule = f"{broken.rule} The file is generated: make it again with `mrts generate`."
        raise InputError(where, rule, key=broken.key, value=broken.value) from None
    if manifest.content_sha256 != manifest.content_hash():
        raise InputError(
            where, "was edited after it was generated. Change the cell file and run `mrts generate` again."
        )
    return manifest


def _check_format(where: Path | str, data: object) -> None:
    """What of a manifest of any format is looked at first."""
    given = data.get("format") if isinstance(data, dict) else None
    if isinstance(given, int) and given != FORMAT:
        rule = f"this mrts reads format {FORMAT}. Make it again with `mrts generate`."
        raise InputError(where, rule, key="format", value=given)


def check_source(where: Path | str, manifest: ChainsRecord, text: str) -> None:
    """Check that a C text is the one that a manifest describes.

    Raises:
        InputError: If it is not.
    """
    if hashlib.sha256(text.encode()).hexdigest() != manifest.source_sha256:
        raise InputError(where, "differs from what its manifest describes. Make both again: `mrts generate`.")

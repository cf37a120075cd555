# SPDX-License-Identifier: MIT
"""manifest.json: all that the run time knows of a cell beside its compiled functions."""

import hashlib
import json
import re
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from mrts.base.errors import InputError
from mrts.base.input_file import IDENTIFIER, Name, broken_rule, read_text

MANIFEST_NAME, CHAINS_NAME = "manifest.json", "chains.json"
GEOMETRY = "geometry"
"""Name of the last input of functions that hold no numbers of a cell file."""

FORMAT = 7
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

MOST = 1000
"""Robots of a cell, joints of a robot, arguments of a function: far above any that can be generated."""

LARGEST_SIZE = 100_000
"""Rows or columns of an argument, likewise."""

Matrix = list[list[float]]
Vector3 = Annotated[list[float], Field(min_length=3, max_length=3)]
Matrix3 = Annotated[list[Vector3], Field(min_length=3, max_length=3)]
Identifier = Annotated[str, Field(pattern=IDENTIFIER, max_length=100)]
Size = Annotated[int, Field(ge=1, le=LARGEST_SIZE)]


def geometry_size(robots: int, held: int) -> int:
    """Entries of a geometry vector.

    Args:
        robots: Number of them.
        held: Numbers of all their `held_numbers`.
    """
    return GRAVITY_SIZE + ROBOT_SIZE * robots + held


class _Record(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class JointRecord(_Record):
    """One joint; axis and a point on it in base axes with every joint at zero; None is unbounded."""

    name: str
    type: Literal["revolute", "prismatic"]
    axis: Vector3
    point: Vector3
    lower: float | None
    upper: float | None
    velocity: float | None
    torque_lower: float
    torque_upper: float


class MotorsRecord(_Record):
    """Motors of one arm, one value a joint (`mrts.motors.joint_motors.JointMotors`); None is unbounded, or no curve."""

    armature: list[float]
    coulomb: list[float]
    viscous: list[float]
    torque_speed: list[list[Annotated[list[float], Field(min_length=2, max_length=2)]] | None]
    torque_rate: list[float | None]
    jerk: list[float | None]
    rated: list[float | None]


class PoseRecord(_Record):
    """A rigid transform: rotation matrix and position [m]."""

    rotation: Matrix3
    position: Vector3


class ContactRecord(_Record):
    """Rows lower <= A F <= upper of one contact, as `mrts.hands.contact.Contact`; None is unbounded, or not given."""

    name: str
    frame: Literal["tip", "object", "base"]
    rows: Annotated[list[str], Field(min_length=1, max_length=LARGEST_SIZE)]
    units: list[str]
    A: Matrix
    lower: list[float | None]
    upper: list[float | None]
    given: dict[str, Any] | None


class RobotRecord(_Record):
    """One arm of the cell."""

    name: Name
    urdf: str
    urdf_sha256: str
    base_link: str
    tip_link: str
    joints: Annotated[list[JointRecord], Field(min_length=1, max_length=MOST)]
    held: dict[str, float]
    held_numbers: Annotated[list[float], Field(max_length=LARGEST_SIZE)]
    base_tip: PoseRecord
    world_base: PoseRecord
    base_root: PoseRecord
    object_tip: PoseRecord
    posture: list[float]
    wrench_lower: list[float | None]
    wrench_upper: list[float | None]
    contact_rate: list[float | None]
    motors: MotorsRecord
    contacts: Annotated[list[ContactRecord], Field(max_length=MOST)]

    @model_validator(mode="after")
    def _one_of_each_a_joint(self) -> Self:
        if len(self.posture) != len(self.joints):
            raise broken_rule("its posture must hold one position a joint")
        if any(len(getattr(self.motors, name)) != len(self.joints) for name in MotorsRecord.model_fields):
            raise broken_rule("its motors must hold one value a joint")
        return self


class ArgumentRecord(_Record):
    """Name and dense shape (rows, columns) of one input or output."""

    name: Identifier
    shape: tuple[Size, Size]


class FunctionRecord(_Record):
    """One generated function."""

    symbol: Identifier
    instructions: Annotated[int, Field(ge=0)]
    inputs: Annotated[list[ArgumentRecord], Field(min_length=1, max_length=MOST)]
    outputs: Annotated[list[ArgumentRecord], Field(min_length=1, max_length=MOST)]


class ObjectRecord(_Record):
    """Nominal load: kg, and kg m² at the com in the object frame; ranges of what may vary (docs/uncertain_load.md).

    Velocity limits are in m/s and rad/s, None is unbounded.
    """

    mass: Annotated[float, Field(gt=0)]
    inertia: Matrix3
    variation: dict[str, tuple[float, float]]
    outer_hull: bool
    linear_velocity: float | None
    angular_velocity: float | None


class RemarkRecord(_Record):
    """What to know of the files that the cell was made from, as `mrts.base.remark.Remark`."""

    code: str
    text: str


class ChainsRecord(_Record):
    """The generated functions: what of them is the same for all cells with the same chains.

    Anyone may have written it: what of it reaches C text or a path is an identifier.
    """

    chains: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    casadi_version: str
    source: str
    source_sha256: str
    functions: dict[Identifier, FunctionRecord]

    @property
    def is_baked(self) -> bool:
        """Whether the functions hold the geometry of one cell as numbers; else it is their last input."""
        return all(one.name != GEOMETRY for function in self.functions.values() for one in function.inputs)

    @model_validator(mode="after")
    def _functions_of_one_file(self) -> Self:
        stem = self.source.removesuffix(".c")
        if self.source == stem or not re.fullmatch(IDENTIFIER, stem):
            raise broken_rule("its source must be the name of a C file: letters, digits, single underscores, and .c")
        for short, function in self.functions.items():
            if function.symbol != f"{stem}_{short}":
                raise broken_rule(f"the symbol of function '{short}' must be the name of the C file, _ and '{short}'")
        for short in ALWAYS_GENERATED:
            if short not in self.functions:
                raise broken_rule(f"its functions must include '{short}'")
        return self

    def to_json(self) -> str:
        """Deterministic text of the file."""
        return json.dumps(self.model_dump(mode="json"), indent=1, allow_nan=False) + "\n"


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
    robots: Annotated[list[RobotRecord], Field(min_length=1, max_length=MOST)]
    machines: Annotated[list[tuple[str, str]], Field(max_length=MOST)]
    remarks: Annotated[list[RemarkRecord], Field(max_length=MOST)]

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        if len({robot.name for robot in self.robots}) < len(self.robots):
            raise broken_rule("two robots have the same name")
        return self

    @model_validator(mode="after")
    def _sizes_agree(self) -> Self:
        size = len(self.wrench_components)
        if size != (len(WRENCH_COMPONENTS) if self.plane is None else 3) or len({*self.wrench_components}) < size:
            raise broken_rule("its wrench components must be three for a plane, else all six")
        for robot in self.robots:
            if {len(robot.wrench_lower), len(robot.wrench_upper), len(robot.contact_rate)} != {size}:
                raise broken_rule(f"the wrench limits of robot '{robot.name}' must be one a wrench component")
            missing = [short for short in FOR_REDUNDANT_ARMS if short not in self.functions]
            if len(robot.joints) > size and missing:
                raise broken_rule(f"its functions must include '{missing[0]}'")
        return self

    def content_hash(self) -> str:
        """Hash of everything in the manifest but the hash itself."""
        content = self.model_dump(mode="json", exclude={"content_sha256"})
        return hashlib.sha256(json.dumps(content, allow_nan=False).encode()).hexdigest()

    def sealed(self) -> Self:
        """The same manifest with its own hash filled in."""
        return self.model_copy(update={"content_sha256": self.content_hash()})


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
        _check_format(where, text)
        manifest = Manifest.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise InputError(
            where, f"{first['msg']}. The file is generated: make it again with `mrts generate`.", key=key
        ) from None
    if manifest.content_sha256 != manifest.content_hash():
        raise InputError(
            where, "was edited after it was generated. Change the cell file and run `mrts generate` again."
        )
    return manifest


class _Format(BaseModel):
    """What of a manifest of any format is looked at first."""

    format: int


def _check_format(where: Path | str, text: str) -> None:
    given = _Format.model_validate_json(text).format
    if given != FORMAT:
        rule = f"this mrts reads format {FORMAT}. Make it again with `mrts generate`."
        raise InputError(where, rule, key="format", value=given)


def check_source(where: Path | str, manifest: ChainsRecord, text: str) -> None:
    """Check that a C text is the one that a manifest describes.

    Raises:
        InputError: If it is not.
    """
    if hashlib.sha256(text.encode()).hexdigest() != manifest.source_sha256:
        raise InputError(where, "differs from what its manifest describes. Make both again: `mrts generate`.")

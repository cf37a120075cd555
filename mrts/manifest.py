# SPDX-License-Identifier: MIT
"""manifest.json: all that the run time knows of a cell beside its compiled functions."""

import hashlib
import json
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from mrts.errors import InputError
from mrts.input_file import read_text

MANIFEST_NAME = "manifest.json"
FORMAT = 4
"""Version of this file's layout; a change that old code cannot read raises it."""

WRENCH_COMPONENTS = ("fx", "fy", "fz", "nx", "ny", "nz")
"""Names of a six-component wrench, forces before moments; a planar cell uses three of them."""

LOAD_ENTRIES = ("mass", "mx", "my", "mz", "ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Layout of a load vector, in the object frame: mass [kg], first moments mass × com [kg m], and the inertia about the
frame's origin, which is the nominal com [kg m²]. The balance of the object is linear in it."""

Matrix = list[list[float]]


class _Record(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class JointRecord(_Record):
    """One joint; axis and a point on it in base axes with every joint at zero; None is unbounded."""

    name: str
    type: Literal["revolute", "prismatic"]
    axis: list[float]
    point: list[float]
    lower: float | None
    upper: float | None
    velocity: float | None
    torque_lower: float
    torque_upper: float


class PoseRecord(_Record):
    """A rigid transform: rotation matrix and position [m]."""

    rotation: Matrix
    position: list[float]


class RobotRecord(_Record):
    """One arm of the cell."""

    name: str
    urdf: str
    urdf_sha256: str
    base_link: str
    tip_link: str
    joints: list[JointRecord]
    held: dict[str, float]
    base_tip: PoseRecord
    world_base: PoseRecord
    object_tip: PoseRecord
    posture: list[float]
    wrench_lower: list[float | None]
    wrench_upper: list[float | None]


class ArgumentRecord(_Record):
    """Name and dense shape (rows, columns) of one input or output."""

    name: str
    shape: tuple[int, int]


class FunctionRecord(_Record):
    """One generated function."""

    symbol: str
    instructions: int
    inputs: list[ArgumentRecord]
    outputs: list[ArgumentRecord]


class ObjectRecord(_Record):
    """Nominal load: kg, and kg m² at the com in the object frame; ranges of what may vary (docs/uncertain_load.md).

    Velocity limits are in m/s and rad/s, None is unbounded.
    """

    mass: float
    inertia: Matrix
    variation: dict[str, tuple[float, float]]
    outer_hull: bool
    linear_velocity: float | None
    angular_velocity: float | None


class RemarkRecord(_Record):
    """What to know of the files that the cell was made from, as `mrts.remark.Remark`."""

    code: str
    text: str


class Manifest(_Record):
    """The whole manifest; see docs/generated_files.md."""

    notice: str
    content_sha256: str
    format: int
    mrts_version: str
    casadi_version: str
    name: Annotated[str, Field(min_length=1)]
    source: str
    source_sha256: str
    plane: Literal["xy", "xz", "yz"] | None
    wrench_components: list[str]
    gravity: list[float]
    object: ObjectRecord
    robots: Annotated[list[RobotRecord], Field(min_length=1)]
    functions: dict[str, FunctionRecord]
    remarks: list[RemarkRecord]

    def to_json(self) -> str:
        """Deterministic text of manifest.json."""
        return json.dumps(self.model_dump(mode="json"), indent=1, allow_nan=False) + "\n"

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
    source = folder / Path(manifest.source).name
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
        manifest = Manifest.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise InputError(
            where, f"{first['msg']}. The file is generated: make it again with `mrts generate`.", key=key
        ) from None
    if manifest.format != FORMAT:
        raise InputError(
            where,
            f"this mrts reads format {FORMAT}. Make it again with `mrts generate`.",
            key="format",
            value=manifest.format,
        )
    if manifest.content_sha256 != manifest.content_hash():
        raise InputError(
            where, "was edited after it was generated. Change the cell file and run `mrts generate` again."
        )
    return manifest


def check_source(where: Path | str, manifest: Manifest, text: str) -> None:
    """Check that a C text is the one that a manifest describes.

    Raises:
        InputError: If it is not.
    """
    if hashlib.sha256(text.encode()).hexdigest() != manifest.source_sha256:
        raise InputError(where, "differs from what its manifest describes. Make both again: `mrts generate`.")

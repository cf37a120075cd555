# SPDX-License-Identifier: MIT
"""What is told of generated functions: names, shapes, layouts; the manifest of a whole cell is `mrts.cell.record`."""

import hashlib
import json
import re
from pathlib import Path
from typing import Annotated, Any

from mrts.base.errors import InputError
from mrts.base.formats.record import Record, Rule
from mrts.base.input_file import IDENTIFIER

MANIFEST_NAME, CHAINS_NAME = "manifest.json", "chains.json"
GEOMETRY = "geometry"
"""Name of the last input of generated functions, which hold no numbers of a cell file."""

FORMAT = 17
"""Version of the manifest's layout; a change that old code cannot read raises it."""

WRENCH_COMPONENTS = ("fx", "fy", "fz", "nx", "ny", "nz")
"""Names of a six-component wrench, forces before moments; a planar cell uses three of them."""

PLANE_COMPONENTS = {
    None: WRENCH_COMPONENTS,
    "xy": ("fx", "fy", "nz"),
    "xz": ("fx", "fz", "ny"),
    "yz": ("fy", "fz", "nx"),
}
"""Those of a cell, by its `plane`."""

WRENCH_UNITS = dict(zip(WRENCH_COMPONENTS, ("N", "N", "N", "N m", "N m", "N m"), strict=True))

LOAD_ENTRIES = ("mass", "mx", "my", "mz", "ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Layout of a load vector, in the object frame: mass [kg], first moments mass × com [kg m], and the inertia about the
frame's origin, which is the nominal com [kg m²]. The balance of the object is linear in it."""

GRAVITY_SIZE, ROBOT_SIZE = 3, 24
"""Layout of a geometry vector: gravity in the world [m/s²]; of each robot the rotation of its base in the world by
rows, its position [m], and those of its tip in the object frame; then `held_numbers` of all (`mrts.Robot`)."""

ALWAYS_GENERATED = (
    *("kinematics", "bias_acceleration", "dynamics", "terms", "wrench_form"),
    *("fixed_distribution", "played_torques"),
)

FOR_REDUNDANT_ARMS = ("geometric_stiffness", "geometric_stiffness_rate")
"""Functions that a cell has besides if an arm has more joints than wrench components."""

OF_MOTION = ("kinematics", "bias_acceleration", *FOR_REDUNDANT_ARMS)
"""Those that the motion of the joints takes, without forces."""

MOST = 1000
"""Robots of a cell, joints of a robot, arguments of a function: far above any that can be generated."""

LARGEST_SIZE = 100_000
"""Rows or columns of an argument, likewise."""

Identifier = Annotated[str, Rule(pattern=IDENTIFIER, max_length=100)]
Size = Annotated[int, Rule(ge=1, le=LARGEST_SIZE)]
Arguments = Annotated[dict[Identifier, tuple[Size, Size]], Rule(min_length=1, max_length=MOST)]


class FunctionRecord(Record):
    """One generated function; what goes in and comes out has a name and a dense shape (rows, columns)."""

    symbol: Identifier
    instructions: Annotated[int, Rule(ge=0)]
    inputs: Arguments
    outputs: Arguments

    @property
    def signature(self) -> str:
        """Names and shapes of what goes in and comes out, as the C has them too."""
        given, found = (
            ", ".join(f"{name}[{rows}x{columns}]" for name, (rows, columns) in side.items())
            for side in (self.inputs, self.outputs)
        )
        return f"{given} -> {found}"


class ChainsRecord(Record):
    """The generated functions: what of them is the same for all cells with the same chains.

    Anyone may have written it: what of it reaches C text or a path is an identifier.
    """

    chains: Annotated[str, Rule(pattern="^[0-9a-f]{64}$")]
    casadi_version: str
    source: str
    source_sha256: str
    functions: dict[Identifier, FunctionRecord]

    def problem(self) -> str:
        """The rule that names break; empty if none."""
        stem = self.source.removesuffix(".c")
        if self.source == stem or not re.fullmatch(IDENTIFIER, stem):
            return "its source must be the name of a C file: letters, digits, single underscores, and .c"
        for short, function in self.functions.items():
            if function.symbol != f"{stem}_{short}":
                return f"the symbol of function '{short}' must be the name of the C file, _ and '{short}'"
        return ""

    def to_json(self) -> str:
        """Deterministic text of the file."""
        return json.dumps(self.model_dump(), indent=1, allow_nan=False) + "\n"


class Manifest(ChainsRecord):
    """What the kernel takes of the manifest of a cell; `mrts.cell.record.CellManifest` is the whole."""

    cell: Any


def check_source(where: Path | str, manifest: ChainsRecord, text: str) -> str:
    """A C text, which must be the one that a manifest describes."""
    if hashlib.sha256(text.encode()).hexdigest() != manifest.source_sha256:
        raise InputError(where, "differs from what its manifest describes. Make both again: `mrts generate`.")
    return text

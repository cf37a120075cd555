# SPDX-License-Identifier: MIT
"""Files that a cell file names, where they are and what they say: URDFs, xacros that become one, a mesh."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from mrts.base.formats.package_uri import file_of_uri, is_uri, is_xacro
from mrts.base.input_file import MAX_FILE_BYTES, MAX_URDF_BYTES
from mrts.base.regular_file import read_regular
from mrts.base.yaml_parser import MAX_YAML_BYTES
from mrts.cell.robot import RobotSource


@dataclass(frozen=True)
class FileReference:
    """What a cell file says of a file.

    Attributes:
        text: A path, relative to the cell file or absolute, or `package://NAME/…`.
        xacro_args: Values of a xacro's arguments, by name.
        key: Where it stands in the cell file.
        what: What it is.
    """

    text: str
    xacro_args: Mapping[str, str] = field(default_factory=dict)
    key: str = "robots[].urdf"
    what: Literal["URDF", "mesh", "joint limits file"] = "URDF"

    def path(self, cell_path: Path, folder: Path) -> Path:
        """Where the file is."""
        if is_uri(self.text):
            return file_of_uri(cell_path, self.text, folder / cell_path.name, key=self.key)
        given = folder / self.text
        return given.parent.resolve() / given.name if ".." in given.parts and "\0" not in self.text else given

    def content(self, cell_path: Path, folder: Path) -> bytes:
        """The file's bytes; of a xacro, the URDF that it becomes with all that it includes."""
        path = self.path(cell_path, folder)
        if self.what == "mesh":
            return read_regular(path, self.what, MAX_FILE_BYTES)
        if self.what == "joint limits file":
            return read_regular(path, self.what, MAX_YAML_BYTES)
        if is_xacro(path):
            from mrts_codegen.urdf.xacro_file import expanded  # noqa: PLC0415 (only for xacros)

            return expanded(path, self.xacro_args)
        return read_regular(path, self.what, MAX_URDF_BYTES)

    def sha256(self, cell_path: Path, folder: Path) -> str:
        """Hash of the content; arguments and errors as `content`."""
        return hashlib.sha256(self.content(cell_path, folder)).hexdigest()


def mesh_reference(text: str, key: str = "object.shape") -> FileReference:
    """What a cell file says of the mesh of its object, or of a body of the surroundings."""
    return FileReference(text, key=f"{key}.mesh", what="mesh")


def robot_reference(source: RobotSource) -> FileReference:
    """What a manifest says of the URDF of an arm."""
    return FileReference(source.urdf, source.xacro_args)

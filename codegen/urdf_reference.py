# SPDX-License-Identifier: MIT
"""Files that a cell file names, where they are and what they say: URDFs, meshes."""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from mrts.base.formats.package_uri import file_of_uri, is_uri
from mrts.base.input_file import MAX_FILE_BYTES, MAX_URDF_BYTES
from mrts.base.regular_file import read_regular
from mrts.base.yaml_parser import MAX_YAML_BYTES

MOST_BYTES = {"URDF": MAX_URDF_BYTES, "mesh": MAX_FILE_BYTES, "joint limits file": MAX_YAML_BYTES}


@dataclass(frozen=True)
class FileReference:
    """What a cell file says of a file.

    Attributes:
        text: A path, relative to the cell file or absolute, or `package://NAME/…`.
        key: Where it stands in the cell file.
        what: What it is.
    """

    text: str
    key: str = "robots[].urdf"
    what: Literal["URDF", "mesh", "joint limits file"] = "URDF"

    def path(self, cell_path: Path, folder: Path) -> Path:
        """Where the file is."""
        if is_uri(self.text):
            return file_of_uri(cell_path, self.text, folder / cell_path.name, key=self.key)
        given = folder / self.text
        return given.parent.resolve() / given.name if ".." in given.parts and "\0" not in self.text else given

    def content(self, cell_path: Path, folder: Path) -> bytes:
        """The file's bytes."""
        return read_regular(self.path(cell_path, folder), self.what, MOST_BYTES[self.what])

    def sha256(self, cell_path: Path, folder: Path) -> str:
        """Hash of the content; arguments and errors as `content`."""
        return hashlib.sha256(self.content(cell_path, folder)).hexdigest()


def mesh_reference(text: str, key: str = "object.shape") -> FileReference:
    """What a cell file says of the mesh of its object, or of a body of the surroundings."""
    return FileReference(text, key=f"{key}.mesh", what="mesh")

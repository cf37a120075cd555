# SPDX-License-Identifier: MIT
"""Input files: where those are that a cell file names, text of a sound size, and the numbers that may stand in it.

A cell file names files by path, or as `package://` and `model://`, found as ROS, Gazebo and pip leave them.
"""

import hashlib
import os
import re
import site
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from posixpath import normpath
from typing import Any, Literal

import numpy as np

from mrts.base.errors import InputError
from mrts.base.regular_file import is_file, is_folder, neighbour, read_regular
from mrts.base.yaml_text import MAX_YAML_BYTES, MAX_YAML_DEPTH, parse_yaml

MAX_FILE_BYTES = 30_000_000
"""Far above any cell, motion, URDF or generated C file: a larger one is a mistake."""

MAX_URDF_BYTES = 3_000_000

LARGEST_NUMBER = 1e12
"""Largest magnitude of a number in an input file, in SI units: anything larger is a mistake and would overflow."""

SMALLEST_NUMBER = 1e-100
"""Smallest size of a number that is not 0, but for coordinates: what is divided by it stays far from overflow."""

IDENTIFIER = r"^[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*$"
"""Letters, digits and single underscores: what C, file names and CasADi all accept."""

LONGEST_NAME = 40


KEYS_OF = {
    "cell file": {"name", "gravity", "plane", "object", "robots"},
    "motion file": {"duration", "samples", "profile", "start", "end", "waypoints", "file", "joints"},
    "study file": {"cell", "motion", "vary", "sample", "count"},
}
"""Keys that only one kind of file has."""

FileKind = Literal["URDF", "mesh", "joint limits file"]
"""What a cell file names."""

XML = ("<?xml", "<robot", "<mujoco", "<sdf")

CLEARLY_OTHER = 2
"""Keys of another kind of file, and none of its own, that tell what a file is."""

URI = re.compile(r"(?:package|model)://([^/]+)/+([^/].*)")

AMENT = "AMENT_PREFIX_PATH"
VARIABLES = (AMENT, "ROS_PACKAGE_PATH", "GZ_SIM_RESOURCE_PATH")
"""Lists of folders in which ROS and Gazebo look for packages."""

LONGEST_MANIFEST = 100_000

MOST_STEPS_UP = 3
"""Folders that a relative path may climb."""

MOST_BYTES = {"URDF": MAX_URDF_BYTES, "mesh": MAX_FILE_BYTES, "joint limits file": MAX_YAML_BYTES}


def read_text(path: Path, what: str, most: int = MAX_FILE_BYTES) -> str:
    """Text of an input file, with Unix line ends.

    Raises:
        InputError: If it is missing, no regular file, unreadable, too large, or not UTF-8.
    """
    return text_of(path, what, read_regular(path, what, most))


def text_of(path: Path, what: str, content: bytes) -> str:
    """Text of an input file's bytes, with Unix line ends; arguments as `read_text`."""
    try:
        text = content.decode()
    except UnicodeDecodeError:
        raise InputError(path, f"this {what} is not UTF-8 text; are two files swapped?") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_data(path: Path, what: str) -> Any:
    """What a YAML file says, not yet validated.

    Raises:
        InputError: If the file is missing, or not YAML.
    """
    text = read_text(path, what, MAX_YAML_BYTES)
    if text.lstrip("\ufeff \n").startswith(XML):
        raise InputError(path, f"this is XML, and a {what} belongs here; `mrts new DIR --robot URDF` makes one.")
    try:
        return parse_yaml(text)
    except ValueError as error:
        raise InputError(path, f"this {what} {error}.") from None


def check_kind(data: dict[Any, Any], what: str) -> None:
    """Refuse a file of another kind by what it is: two that were given in the wrong order, rather than unknown keys."""
    if what in KEYS_OF and not KEYS_OF[what] & data.keys():
        for other, keys in KEYS_OF.items():
            if len(keys & data.keys()) >= CLEARLY_OTHER:
                is_study = other == "study file"
                taken = "`mrts sweep` takes it." if is_study else "are two files swapped?"
                raise InputError("", f"this is a {other}, and a {what} belongs here: {taken}")


def plain(where: str, data: object, depth: int = MAX_YAML_DEPTH) -> object:
    """A value as a YAML file could hold it: numpy's arrays and numbers, tuples and paths become lists, numbers, text.

    Raises:
        InputError: If they lie deeper, as where one holds itself.
    """
    if depth < 0:
        raise InputError(where, f"its lists and keys may lie {MAX_YAML_DEPTH} deep at most.")
    if isinstance(data, Mapping):
        return {key: plain(where, value, depth - 1) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [plain(where, value, depth - 1) for value in data]
    if isinstance(data, np.ndarray):
        return plain(where, data.tolist(), depth - 1)
    if isinstance(data, np.generic):
        return data.item()
    return str(data) if isinstance(data, Path) else data


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
    what: FileKind = "URDF"

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


def named_in(folder: Path, file: Path) -> str:
    """How a file in a folder names another: from there, or by its whole path where that is far away."""
    try:
        near = Path(os.path.relpath(file.absolute(), folder.resolve()))
    except ValueError:  # no path at all, which writing refuses
        return str(file)
    return near.as_posix() if near.parts.count("..") <= MOST_STEPS_UP else file.absolute().as_posix()


def is_uri(reference: str) -> bool:
    """Whether a reference to a file names a package."""
    return reference.startswith(("package://", "model://"))


def file_of_uri(where: Path | str, uri: str, near: Path, *, key: str = "") -> Path:
    """The file that a `package://NAME/…` or `model://NAME/…` means.

    Looked for in folders above the file that names it (the folder NAME, or one whose package.xml has that name); where
    ROS and Gazebo look by their environment variables; in share folders of installed packages; in the installed Python
    package NAME. The first that holds the file is taken.

    Raises:
        InputError: If no package holds it, or it would lead out of the package.
    """
    match = URI.fullmatch(uri)
    if match is None:
        raise InputError(where, "must be package://NAME/PATH: a package, and a file in it.", key=key, value=uri)
    package, inside = match.groups()
    if normpath(inside).partition("/")[0] == "..":
        rule = f"leads out of the package '{package}'. Name the package that holds the file, or give a file path."
        raise InputError(where, rule, key=key, value=uri)
    folders = list(_package_folders(package, near))
    found = next((folder / inside for folder in folders if is_file(folder / inside)), None)
    if found is not None:
        return found
    if folders:
        there = ", ".join(dict.fromkeys(map(str, folders)))
        rule = f"the package '{package}' is at {there}, but holds no file '{inside}'{neighbour(folders[0] / inside)}"
        raise InputError(where, rule, key=key, value=uri)
    looked = ", ".join(map(str, _share_folders())) or "no share folder"
    rule = (
        f"the package '{package}' is not found. Looked in the folders above that file, where those of "
        f"{', '.join(VARIABLES)} point to that are set, in {looked}, and among installed Python packages. Source the "
        f"workspace's setup file, install the package, put its folder '{package}' beside that file or above, or give "
        "a file path."
    )
    raise InputError(where, rule, key=key, value=uri)


def _package_folders(package: str, near: Path) -> Iterator[Path]:
    if package in {".", ".."}:
        return
    for above in near.resolve().parents:
        if is_folder(above / package):
            yield above / package
        if _is_named(above, package):
            yield above
    of_variables = (
        Path(folder) / ("share" if name == AMENT else "")
        for name in VARIABLES
        for folder in os.environ.get(name, "").split(os.pathsep)
        if folder
    )
    yield from (root / package for root in (*of_variables, *_share_folders()) if is_folder(root / package))
    spec = find_spec(package) if package.isidentifier() else None
    if spec is not None:
        yield from map(Path, spec.submodule_search_locations or ())


def _share_folders() -> list[Path]:
    """Folders `share` of installed packages: Python's own, and those of cmeel, such as example-robot-data."""
    installed = [Path(folder) for folder in (*sys.path, *site.getsitepackages()) if folder]
    prefixes = [Path(sys.prefix), *(folder / "cmeel.prefix" for folder in installed)]
    return [prefix / "share" for prefix in dict.fromkeys(prefixes) if (prefix / "share").is_dir()]


def _is_named(folder: Path, package: str) -> bool:
    try:
        with (folder / "package.xml").open(encoding="utf-8", errors="replace") as file:
            text = file.read(LONGEST_MANIFEST)
    except OSError:
        return False
    return re.search(rf"<name>\s*{re.escape(package)}\s*</name>", text) is not None

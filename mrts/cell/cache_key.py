# SPDX-License-Identifier: MIT
"""What a generated cell depends on, without the symbolic layer: looking into the cache must cost next to nothing."""

import hashlib
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from mrts.base import version
from mrts.base.errors import InputError
from mrts.base.formats.file_reference import FileReference
from mrts.base.regular_file import read_regular
from mrts.base.yaml_text import MAX_YAML_BYTES
from mrts.cell.record import CellRecord

SHAPING = (
    *("base/manifest.py", "base/rigid_transform.py", "base/input_file.py", "base/yaml_text.py", "base/load_box.py"),
    *(
        "base/formats/*.py",
        "cell/record.py",
        "cell/robot.py",
        "cell/hands.py",
        "cell/motors.py",
        "cell/points.py",
        "cell/cell_file.py",
    ),
)
"""Files of mrts that decide what a manifest says."""


def text_key(path: Path) -> str:
    """Hash of a cell file's text and of what reads it: its manifest is the same while the hashes of its URDFs are."""
    text = read_regular(path, "cell file", MAX_YAML_BYTES)
    return hashlib.sha256(emitter_key().encode() + text).hexdigest()


def is_as_made(path: Path, record: CellRecord) -> bool:
    """Whether the files that a cell file names hold what the record of a cell was made from."""
    folder = path.resolve().parent
    sources = [robot.source for robot in record.robots]
    known = [(FileReference(source.urdf), source.sha256) for source in sources]
    known += [(FileReference(one.joint_limits[0]), one.joint_limits[1]) for one in sources if one.joint_limits]
    known += [(FileReference(file, what="mesh"), surface.sha256) for file, surface in record.surfaces.items()]
    try:
        return all(reference.sha256(path, folder) == made for reference, made in known)
    except InputError:
        return False


@cache
def emitter_key() -> str:
    """Hash of what reads cells and emits functions: mrts_codegen and CasADi's version."""
    package = Path(version.__file__).parents[1]
    shaping = [source for pattern in SHAPING for source in package.glob(pattern)]
    folder = _package_folder("mrts_codegen")
    ours = [source for source in folder.rglob("*.py") if source.parent.name != "embedded"]
    digest = hashlib.sha256("\n".join([*_casadi_versions(), version.__version__]).encode())
    for source in sorted([*ours, *shaping]):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def _casadi_versions() -> list[str]:
    """Names of the metadata folders beside CasADi: `importlib.metadata`, which reads them, is slow to import."""
    return sorted(path.name for path in _package_folder("casadi").parent.glob("casadi-*"))


def _package_folder(name: str) -> Path:
    found = find_spec(name)
    if found is None or found.origin is None:
        raise InputError(name, "is not installed: pip install mrts.")
    return Path(found.origin).parent

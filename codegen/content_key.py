# SPDX-License-Identifier: MIT
"""What a generated cell depends on, without the symbolic layer: looking into the cache must cost next to nothing."""

import hashlib
import json
from importlib.metadata import version
from pathlib import Path

from mrts_codegen.cell_description import CellDescription, read_cell_description, resolve_urdf

from mrts import __version__, input_file, load_box, manifest, rigid_transform


def content_key(path: Path) -> str:
    """Hash of all that a generated cell depends on: cell file, URDFs, this package and CasADi's version.

    Raises:
        InputError: If the cell file breaks a rule or a URDF is missing.
    """
    description = read_cell_description(path)
    parts = [json.dumps(description.model_dump(), sort_keys=True), version("casadi"), __version__]
    digest = hashlib.sha256("\n".join(parts).encode())
    for robot in description.robots:
        digest.update(_file_bytes(path, description, robot.urdf))
    shaping = (manifest, rigid_transform, input_file, load_box)
    for source in sorted([*Path(__file__).parent.glob("*.py"), *(Path(module.__file__ or "") for module in shaping)]):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def _file_bytes(path: Path, description: CellDescription, urdf: str) -> bytes:
    try:
        return resolve_urdf(path, urdf).read_bytes()
    except (OSError, ValueError):
        # generation itself gives the precise error; a file that cannot be read has no cache entry
        from mrts_codegen.cell_model import build_cell_model  # noqa: PLC0415 (only for the message)

        build_cell_model(path, description)
        raise

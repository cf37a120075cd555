# SPDX-License-Identifier: MIT
"""Where the URDF of a robot is."""

import re
from pathlib import Path

from mrts.base.errors import InputError
from mrts.base.input_file import IDENTIFIER


def resolve_urdf(cell_path: Path, folder: Path, reference: str) -> Path:
    """Path of a robot's URDF: relative to the cell file, absolute, or `package://NAME/…` of an installed package.

    Args:
        cell_path: The cell file, for messages.
        folder: Where it stands, absolute.
        reference: What it says.

    Raises:
        InputError: If a `package://` name is not an installed Python package.
    """
    match = re.fullmatch(r"package://([^/]+)/(.+)", reference)
    if not match:
        return folder / reference
    from importlib.util import find_spec  # noqa: PLC0415 (only for package:// references)

    package, inside = match.groups()
    spec = find_spec(package) if re.fullmatch(IDENTIFIER, package) else None
    if spec is None or not spec.submodule_search_locations:
        raise InputError(
            cell_path,
            f"'{package}' is not an installed Python package. Install it, or give a file path.",
            key="robots[].urdf",
            value=reference,
        )
    return Path(next(iter(spec.submodule_search_locations))) / inside

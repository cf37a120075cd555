# SPDX-License-Identifier: MIT
"""Cells whose joints can be moved, but of which no C was generated: where the arms reach is known in a moment."""

from pathlib import Path
from typing import Any

from mrts.base.argument_types import as_path
from mrts.cell.cell import Cell
from mrts.cell.functions import uncompiled_functions
from mrts.cell.generation import motion_functions_of, read_to_generate
from mrts.cell.loading import cell_from_manifest
from mrts.cell.source_files import is_generated


def uncompiled_cell(model: Any, folder: Path) -> Cell:
    """A cell that can follow motions, and nothing else.

    Args:
        model: The cell with its URDFs, as from `mrts.cell.generation`.
        folder: That its URDFs are relative to, absolute.
    """
    manifest, functions = motion_functions_of(model)
    return cell_from_manifest(manifest, uncompiled_functions(manifest, functions), folder)


def cell_to_compile(path: Path | str) -> Cell | None:
    """The cell of a file that would have to be generated and compiled first, as `uncompiled_cell`; None of any other.

    Args:
        path: A cell file, or a folder that `mrts generate` wrote.

    Raises:
        InputError: If the cell file or a URDF breaks a rule.
    """
    path = as_path("path", path)
    if is_generated(path):
        return None
    model = read_to_generate(path)
    return None if model is None else uncompiled_cell(model, path.resolve().parent)

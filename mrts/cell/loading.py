# SPDX-License-Identifier: MIT
"""Cells from files, from dictionaries and from manifests."""

from os import PathLike
from pathlib import Path
from types import NoneType
from typing import Any

from mrts.base.argument_types import as_path, check_type
from mrts.base.regular_file import is_folder
from mrts.cell.cell import Cell
from mrts.cell.functions import CellFunctions, compiled_functions, uncompiled_functions
from mrts.cell.generation import (
    described_in_cache,
    described_model,
    generated_in_cache,
    motion_functions_of,
    read_to_generate,
)
from mrts.cell.record import read_generated
from mrts.cell.source_files import is_generated


def load_cell(path: Path | str) -> Cell:
    """Read a cell: generate and compile it on first use, from the cache after that.

    Args:
        path: A cell file, or a folder that `mrts generate` wrote.

    Raises:
        InputError: If the cell file, a URDF or the generated folder breaks a rule.
        CompilerError: If there is no C compiler, or it fails.
    """
    path = as_path("path", path)
    if is_generated(path):
        return cell_of(compiled_functions(*read_generated(path if is_folder(path) else path.parent)))
    return cell_of(compiled_functions(*generated_in_cache(path)), path.resolve().parent)


def described_cell(description: object, folder: Path | str | None) -> Cell:
    """A cell from a dictionary; see `mrts.Cell.from_description`."""
    check_type("folder", folder, str, PathLike, NoneType)
    here = (Path() if folder is None else as_path("folder", folder)).absolute()
    return cell_of(compiled_functions(*described_in_cache(described_model(description, here))), here)


def cell_of(functions: CellFunctions, folder: Path | None = None) -> Cell:
    """The cell that the manifest of functions describes."""
    return Cell(**functions.manifest.cell.record(), functions=functions, folder=folder)


def uncompiled_cell(model: Any, folder: Path) -> Cell:
    """A cell that can follow motions, and nothing else."""
    return cell_of(uncompiled_functions(*motion_functions_of(model)), folder)


def cell_to_compile(path: Path | str) -> Cell | None:
    """The cell of a file that is yet to be generated and compiled, as `uncompiled_cell`; None of any other."""
    path = as_path("path", path)
    if is_generated(path):
        return None
    model = read_to_generate(path)
    return None if model is None else uncompiled_cell(model, path.resolve().parent)

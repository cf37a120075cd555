# SPDX-License-Identifier: MIT
"""Cells from files, from dictionaries and from manifests."""

from os import PathLike
from pathlib import Path
from types import NoneType

from mrts.base.argument_types import as_path, check_type
from mrts.base.regular_file import is_folder
from mrts.cell.cell import Cell
from mrts.cell.functions import CellFunctions, compiled_functions
from mrts.cell.generation import described_in_cache, generated_in_cache
from mrts.cell.record import CellManifest, CellRecord, read_generated
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
        manifest, source = read_generated(path if is_folder(path) else path.parent)
        return cell_from_manifest(manifest, compiled_functions(manifest, source))
    manifest, source = generated_in_cache(path)
    return cell_from_manifest(manifest, compiled_functions(manifest, source), path.resolve().parent)


def described_cell(description: object, folder: Path | str | None) -> Cell:
    """A cell from a dictionary; see `mrts.Cell.from_description`.

    Raises:
        InputError: If the description or a URDF breaks a rule.
        CompilerError: If there is no C compiler, or it fails.
    """
    check_type("folder", folder, str, PathLike, NoneType)
    here = (Path() if folder is None else as_path("folder", folder)).absolute()
    manifest, source = described_in_cache(description, here)
    return cell_from_manifest(manifest, compiled_functions(manifest, source), here)


def cell_from_manifest(manifest: CellManifest, functions: CellFunctions, folder: Path | None = None) -> Cell:
    """The cell that a manifest describes.

    Args:
        manifest: The description.
        functions: The generated functions.
        folder: That its URDFs are relative to; None where that is not known.
    """
    record = {name: getattr(manifest, name) for name in CellRecord.model_fields}
    return Cell(**record, functions=functions, folder=folder)

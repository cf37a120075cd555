# SPDX-License-Identifier: MIT
"""Cells from files, from dictionaries and from manifests."""

from functools import partial
from os import PathLike
from pathlib import Path
from types import NoneType

import numpy as np

from mrts.base.argument_types import as_path, check_type
from mrts.base.arrays import with_infinity
from mrts.base.errors import InputError
from mrts.base.load_box import LoadBox, load_vector
from mrts.base.manifest import Manifest, read_generated
from mrts.base.regular_file import is_folder
from mrts.base.remark import Remark
from mrts.cell.cell import Cell
from mrts.cell.functions import Backend, CellFunctions, bind_functions
from mrts.cell.generation import described_in_cache, generated_in_cache, virtual_machine_functions
from mrts.cell.robot import robot_from_record
from mrts.cell.source_files import is_generated


def load_cell(path: Path | str, *, backend: Backend = "auto") -> Cell:
    """Read a cell: generate and compile it on first use, from the cache after that.

    Args:
        path: A cell file, or a folder that `mrts generate` wrote.
        backend: "auto" compiles the C and falls back to CasADi's virtual machine where there is no compiler;
            "compiled" and "vm" insist.

    Raises:
        InputError: If the cell file, a URDF or the generated folder breaks a rule.
        CompilerError: If the compiler fails.
    """
    _check_backend(backend)
    path = as_path("path", path)
    if is_generated(path):
        manifest, source = read_generated(path if is_folder(path) else path.parent)
        return cell_from_manifest(manifest, bind_functions(manifest, source, backend, None))
    manifest, source = generated_in_cache(path)
    functions = bind_functions(manifest, source, backend, partial(virtual_machine_functions, path))
    return cell_from_manifest(manifest, functions, path.resolve().parent)


def described_cell(description: object, folder: Path | str | None, backend: Backend) -> Cell:
    """A cell from a dictionary; see `mrts.Cell.from_description`.

    Raises:
        InputError: If the description or a URDF breaks a rule.
        CompilerError: If the compiler fails.
    """
    _check_backend(backend)
    check_type("folder", folder, str, PathLike, NoneType)
    here = (Path() if folder is None else as_path("folder", folder)).absolute()
    manifest, source, machine = described_in_cache(description, here)
    return cell_from_manifest(manifest, bind_functions(manifest, source, backend, machine), here)


def _check_backend(backend: object) -> None:
    check_type("backend", backend, str)
    if backend not in {"auto", "compiled", "vm"}:
        raise InputError("backend", "must be 'auto', 'compiled' or 'vm'.", value=backend)


def cell_from_manifest(manifest: Manifest, functions: CellFunctions, folder: Path | None = None) -> Cell:
    """The cell that a manifest describes.

    Args:
        manifest: The description.
        functions: The generated functions.
        folder: That its URDFs are relative to; None where that is not known.
    """
    carried = manifest.object
    inertia = np.array(carried.inertia)
    return Cell(
        name=manifest.name,
        plane=manifest.plane,
        wrench_components=tuple(manifest.wrench_components),
        gravity=np.array(manifest.gravity),
        load=load_vector(carried.mass, np.zeros(3), inertia),
        load_box=LoadBox(carried.mass, inertia, carried.variation, carried.outer_hull) if carried.variation else None,
        object_velocity_limit=with_infinity([carried.linear_velocity, carried.angular_velocity], np.inf),
        object_shape=carried.shape,
        robots=functions.robots if manifest is functions.manifest else tuple(map(robot_from_record, manifest.robots)),
        functions=functions,
        remarks=tuple(Remark(record.code, record.text, severity=record.severity) for record in manifest.remarks),
        folder=folder,
    )

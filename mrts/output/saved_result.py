# SPDX-License-Identifier: MIT
"""A result in one file: all that was found, read again without a compiler; see docs/saved_results.md."""

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import NoneType
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from mrts.base.atomic_file import write_atomically
from mrts.base.errors import InputError, SolverError, as_path, check_type
from mrts.base.load_box import LoadBox
from mrts.base.manifest import FORMAT
from mrts.base.regular_file import open_regular
from mrts.base.version import __version__
from mrts.cell.cell import Cell
from mrts.cell.cell_keys import manifest_of
from mrts.cell.generation import GeneratedFunctions
from mrts.cell.record import CellManifest, other_functions
from mrts.limits.rows import limit_name
from mrts.output.value_tree import Arrays, TreeReader, TreeWriter
from mrts.scaling.scale import ScalingResult
from mrts.scaling.what_if import WhatIf
from mrts.timing.result import RetimingResult

FORMAT_NAME = "mrts result"

VERSION = 17
"""Of arrays and description together; any change of what results hold raises it, unless it is one of the manifest."""

DESCRIPTION_BYTES = 5_000_000
DESCRIPTION_RATIO = 20
"""The words of a result take at most so many bytes, or so many times its file: parsed, they are a dozen times larger.
They shrink to about a sixth where many samples are infeasible."""

ADVICE = "`mrts scale CELL MOTION --save FILE.npz` writes one."

MAX_ARCHIVE_BYTES = 2_000_000_000
"""A million samples of two arms take less than half of it."""

UNPACKED_BYTES = 30_000_000
UNPACKED_RATIO = 50
"""An archive may unpack to so many bytes and so many times its own size: results shrink to about a third, nothing but
zeros to a thousandth."""

FOUND: dict[str, tuple[str, ...]] = {
    "ScalingResult": ("reserve", "warnings"),
    "ScaledTrajectory": ("internal_wrench",),
    "RetimingResult": ("segment_limits", "factor"),
}
"""What is found once and kept: finding it again takes the cell's functions."""


def save_result(result: ScalingResult | RetimingResult, path: Path | str) -> None:
    """Write a result to a file, whole or not at all; the same result makes the same bytes.

    Args:
        result: The result.
        path: The file to make or replace, by custom NAME.npz.

    Raises:
        InputError: If the file cannot be written.
    """
    check_type("result", result, ScalingResult, RetimingResult)
    path, found = as_path("path", path), dict(FOUND)
    if isinstance(result, RetimingResult) and result.retimed is None:  # a report shows the constant factor instead
        with suppress(SolverError):  # of limits of rates that leave no torques
            result.constant  # noqa: B018 (found now, it is kept)
            found["RetimingResult"] += ("constant",)
    writer = TreeWriter({Cell: _cell_entry}, found)
    known = {"format": FORMAT_NAME, "version": VERSION, "manifest_format": FORMAT, "mrts_version": __version__}
    text = json.dumps(known | {"result": writer.entry(result, "")}, ensure_ascii=False)
    arrays: dict[str, Any] = writer.arrays | {"description": np.frombuffer(text.encode(), dtype=np.uint8)}
    arrays["seal"] = seal(arrays)

    def write(temporary: Path) -> None:
        with temporary.open("wb") as file:
            np.savez_compressed(file, **arrays)

    write_atomically(path, write)


def load_result(path: Path | str, cell: Cell | None = None) -> ScalingResult | RetimingResult:
    """Read a result that `save_result` wrote; nothing in the file is executed.

    Without `cell` everything works that was found and kept; what takes the cell's compiled functions (`residuals`,
    `torques_for_load`, a new `scale`) says so.

    Args:
        path: The file.
        cell: The same cell from `load_cell`: its functions are then at hand, and limits that it was given in Python.
            Those of its file, postures and load do not count; the result keeps those that it was found with.

    Raises:
        InputError: If the file is no saved result, not whole, edited, of another version, of another cell, or of one
            that was given other limits in Python.
    """
    path = as_path("path", path)
    check_type("cell", cell, Cell, NoneType)

    def read_cell(reader: TreeReader, entry: dict[str, Any], place: str) -> Cell:
        manifest = CellManifest.model_validate(entry["manifest"])
        generated = GeneratedFunctions(manifest, path) if cell is None else _generated_of(cell, manifest, path)
        names, given = entry["limits"], () if cell is None else cell.limits
        if names != (others := list(map(limit_name, given))):
            rule = (
                f"was found with {_own_limits(names)}, and is read with {_own_limits(others)}. Give mrts.load_result a "
                "cell that has the same."
            )
            raise InputError(path, rule, key="limits")
        record = manifest.cell.record()
        record["load_box"] = reader.value(LoadBox | None, entry["load_box"], f"{place}.load_box")
        return Cell(
            **record,
            generated=generated,
            enforces_velocity_limits=entry["enforces_velocity_limits"],
            reserve=entry["reserve"],
            limits=given,
            folder=None if cell is None else cell.folder,
        )

    with _opened(path) as (arrays, size):
        text, found_seal = arrays["description"].tobytes(), arrays.pop("seal", np.zeros(0))
        if len(text) > max(DESCRIPTION_BYTES, DESCRIPTION_RATIO * size):
            raise InputError(path, f"describes a result in {len(text)} bytes: more than a file of its size.")
        said = _checked_description(path, text)
        if not np.array_equal(found_seal, seal(arrays)):
            raise InputError(path, "was edited or damaged after it was saved. Save the result again.", key="seal")
        reader = TreeReader(arrays, {Cell: read_cell}, {"WhatIf": WhatIf})
        result: ScalingResult | RetimingResult = reader.value(ScalingResult | RetimingResult, said["result"], "")
        return result


@contextmanager
def _opened(path: Path) -> Iterator[tuple[dict[str, NDArray[Any]], int]]:
    """The arrays of an .npz file by name, none that would have to be unpickled, and its size in bytes.

    Raises:
        InputError: If it is missing, no regular file, no such archive, or damaged; also of what the block raises.
    """
    with open_regular(path, "saved result", MAX_ARCHIVE_BYTES) as file:
        try:
            size = file.seek(0, os.SEEK_END)
            with ZipFile(file) as archive:
                unpacked = sum(member.file_size for member in archive.infolist())
            if unpacked > UNPACKED_BYTES + UNPACKED_RATIO * size:
                raise ValueError(f"it would unpack to {unpacked} bytes")  # noqa: TRY301
            file.seek(0)
            with np.load(file) as arrays:
                yield dict(arrays), size
        except Exception as error:
            if isinstance(error, InputError) and error.where == str(path):
                raise
            raise InputError(path, f"is no saved result of mrts, or damaged ({error}). {ADVICE}") from None


def _cell_entry(writer: TreeWriter, cell: Cell, path: str) -> dict[str, Any]:
    return {
        "class": "Cell",
        "manifest": manifest_of(cell).model_dump(),
        "load_box": writer.entry(cell.load_box, f"{path}.load_box"),
        "enforces_velocity_limits": cell.enforces_velocity_limits,
        "reserve": cell.reserve,
        "limits": list(map(limit_name, cell.limits)),
    }


def seal(arrays: Arrays) -> NDArray[Any]:
    """Hash of all that a file holds."""
    digest = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        digest.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return np.frombuffer(digest.digest(), dtype=np.uint8)


def _checked_description(path: Path, text: bytes) -> dict[str, Any]:
    try:
        said: Any = json.loads(text)
    except (ValueError, RecursionError):
        said = None
    if not isinstance(said, dict) or said.get("format") != FORMAT_NAME:
        raise InputError(path, "is no saved result of mrts. Make one with mrts.save_result or `mrts scale --save`.")
    version = said.get("version")
    if (version, said.get("manifest_format")) != (VERSION, FORMAT):
        newer = isinstance(version, int) and version > VERSION
        advice = "Update mrts to read it." if newer else "Save the result again."
        raise InputError(
            path,
            f"this mrts reads version {VERSION} with manifests of format {FORMAT}; the file was written by mrts "
            f"{said.get('mrts_version')}. {advice}",
            key="version",
            value=version,
        )
    return said


def _own_limits(names: list[str]) -> str:
    return f"the limits {', '.join(names)} of Python" if names else "no limits but those of its file"


def _generated_of(cell: Cell, saved: CellManifest, path: Path) -> GeneratedFunctions:
    if what := other_functions(cell.generated.manifest.cell, saved.cell):
        raise InputError(
            path,
            f"cell '{cell.name}' is another one than the result was found with, '{saved.cell.name}': they differ "
            f"in {what}. Read the cell file that it was found with.",
            key="cell",
        )
    return cell.generated

# SPDX-License-Identifier: MIT
"""What `mrts view` is asked to show: a cell and a motion, a variant of a study, or a saved result."""

import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from mrts.base.errors import InputError
from mrts.base.regular_file import is_folder

if TYPE_CHECKING:
    from mrts.scaling.result import ScalingResult
    from mrts.studies.study import Study


def is_saved(path: Path) -> bool:
    """Whether a file is a saved result."""
    return path.suffix == ".npz"


@contextmanager
def shown_files(
    cell: Path, motion: Path | None, variant: int | None, changing: Iterable[str], needing: Iterable[str]
) -> Iterator[tuple[Path, Path | None]]:
    """The files of what is shown, cell and motion, as long as it is.

    Args:
        cell: As named on the line.
        motion: Likewise.
        variant: Of the study that `cell` names.
        changing: Names of the arguments given that change the answer.
        needing: Names of those that need a motion besides.

    Raises:
        InputError: If what was named does not go together, or there is no such variant.
    """
    if is_saved(cell):
        if motion is not None:
            raise InputError(cell, "a saved result holds its motion.", key="MOTION")
        for name in ["variant"] * (variant is not None) + [*changing]:
            raise InputError(name, f"does not go with {cell}: a saved result is played as it was found.")
        yield cell, None
    elif variant is not None:
        if motion is not None:
            rule = "does not go with --variant: the study has it."
            raise InputError(cell, rule, key="MOTION", value=str(motion))
        study = _study(cell)
        if not 0 <= variant < study.variants:
            raise InputError(cell, f"must be from 0 to {study.variants - 1}.", key="--variant", value=variant)
        with tempfile.TemporaryDirectory(prefix="mrts-variant-") as folder:
            yield study.write_variant(variant, Path(folder))
    else:
        from mrts.studies.study_folder import STUDY_FILE

        if motion is None and (cell / STUDY_FILE).exists():
            raise InputError(cell, "is needed: which variant of the study?", key="--variant")
        for name in [*changing, *needing] if motion is None else ():
            raise InputError(name, "needs a motion: mrts view CELL MOTION.")
        yield cell, motion


def played(path: Path) -> "ScalingResult":
    """A saved result that has something to play.

    Raises:
        InputError: If it is none, or no speed is admissible.
    """
    from mrts.output.saved_result import load_result
    from mrts.scaling.result import ScalingResult

    found = load_result(path)
    result = found if isinstance(found, ScalingResult) else found.retimed
    if result is None or result.trajectory is None:
        possible = "what some load admits chooses no c² and no torques"
        why = possible if found.status.admits_motion else found.status.value
        raise InputError(path, f"has no motion to play: {why}.")
    return result


def shown_urdfs(cell: Path) -> dict[str, tuple[Path, str | None]]:
    """URDF and base link by robot, whose meshes arms are drawn with; nothing where only generated code is at hand."""
    from mrts.base.manifest import MANIFEST_NAME
    from mrts.cell.source_files import urdf_files

    return {} if is_folder(cell) or cell.name == MANIFEST_NAME else urdf_files(cell)


def _study(path: Path) -> "Study":
    from mrts.studies.study_file import read_study

    if not is_folder(path):
        return read_study(path)
    from mrts.studies.study_folder import read_study_folder

    folder = read_study_folder(path)
    name = Path(folder.record["study"]["file"]).name
    tried = list(dict.fromkeys((place / name).absolute() for place in (path.parent, Path(), path)))
    for file in tried:
        if file.is_file() and (study := read_study(file)).digest == folder.digest:
            return study
    rule = f"its study file {name} is not beside it, or has changed: name the study file in place of the folder."
    raise InputError(path, rule)

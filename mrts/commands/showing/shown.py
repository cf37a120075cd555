# SPDX-License-Identifier: MIT
"""What `mrts view` is asked to show: a cell and a motion, a variant of a study, or a saved result."""

import argparse
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from mrts.base.errors import InputError
from mrts.base.regular_file import is_folder

if TYPE_CHECKING:
    from mrts.scaling.result import ScalingResult
    from mrts.studies.study import Study

SAVED = ".npz"

QUESTIONS = {"share": None, "closure": None, "reserve": 0.0, "no_wrench_limits": False, "no_velocity_limits": False}
"""Options that change the answer, and their values where they are not given."""


def add_shown(view: argparse.ArgumentParser) -> None:
    """Add the arguments that say what is shown."""
    view.add_argument("cell", type=Path, metavar="CELL",
                      help="cell file, folder that `mrts generate` wrote, RESULT.npz of `mrts scale --save`, or, "
                      "with --variant, a study file or the folder of its sweep")  # fmt: skip
    view.add_argument("motion", type=Path, metavar="MOTION", nargs="?",
                      help="motion file, CSV table, or ROS 2 bag with joint trajectories; without one the cell stands "
                      "at its posture, and no compiler is needed")  # fmt: skip
    view.add_argument("--with", type=Path, action="append", default=[], dest="others", metavar="RESULT.npz",
                      help="a saved result to show beside it; may be given again")  # fmt: skip
    view.add_argument("--variant", type=int, metavar="N", help="of the study: its cell and its motion")


def is_saved(options: argparse.Namespace) -> bool:
    """Whether a saved result is to be shown."""
    return bool(options.cell.suffix == SAVED)


@contextmanager
def shown_files(options: argparse.Namespace) -> Iterator[None]:
    """Let `options.cell` and `options.motion` name the files of what is shown, as long as it is; a result's stay.

    Raises:
        InputError: If what was named does not go together, or there is no such variant.
    """
    if is_saved(options):
        if options.motion is not None or options.variant is not None:
            other = "MOTION" if options.motion is not None else "--variant"
            raise InputError(options.cell, "a saved result holds its motion.", key=other)
        for name, nothing in QUESTIONS.items():
            if getattr(options, name) != nothing:
                option = f"--{name.replace('_', '-')}"
                raise InputError(options.cell, "a saved result is played as it was found.", key=option)
        yield
    elif options.variant is not None:
        if options.motion is not None:
            rule = "does not go with --variant: the study has it."
            raise InputError(options.cell, rule, key="MOTION", value=str(options.motion))
        study = _study(options.cell)
        if not 0 <= options.variant < study.variants:
            rule = f"must be from 0 to {study.variants - 1}."
            raise InputError(options.cell, rule, key="--variant", value=options.variant)
        with tempfile.TemporaryDirectory(prefix="mrts-variant-") as folder:
            options.cell, options.motion = study.write_variant(options.variant, Path(folder))
            yield
    else:
        if options.motion is None:
            _check_alone(options)
        yield


def _check_alone(options: argparse.Namespace) -> None:
    """A cell without a motion is looked at; what only a motion can have is refused."""
    from mrts.studies.study_folder import STUDY_FILE

    if (options.cell / STUDY_FILE).exists():
        raise InputError(options.cell, "is needed: which variant of the study?", key="--variant")
    asked = [name for name, nothing in QUESTIONS.items() if getattr(options, name) != nothing]
    asked += [name for name in ("png", "video") if getattr(options, name) is not None]
    asked += ["with"] if options.others else []
    if asked:
        raise InputError("MOTION", f"is needed for --{asked[0].replace('_', '-')}: mrts view CELL MOTION.")


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
        raise InputError(path, f"has no motion to play: {found.status.value}.")
    return result


def shown_urdfs(options: argparse.Namespace) -> dict[str, tuple[Path, str | None]]:
    """URDF and base link by robot, whose meshes arms are drawn with; nothing where only generated code is at hand."""
    from mrts.base.manifest import MANIFEST_NAME
    from mrts.cell.source_files import urdf_files

    return {} if is_folder(options.cell) or options.cell.name == MANIFEST_NAME else urdf_files(options.cell)


def _study(path: Path) -> "Study":
    """A study, from its file or the folder of its sweep."""
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

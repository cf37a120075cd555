# SPDX-License-Identifier: MIT
"""A study: a cell and a motion of which numbers vary, and what is asked of each variant."""

import os
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np

from mrts.base.argument_types import as_path, check_callable, check_type
from mrts.base.arrays import Array
from mrts.base.atomic_file import text_writer, write_atomically, write_together
from mrts.base.errors import InputError, as_array
from mrts.base.formats.package_uri import is_uri
from mrts.base.formats.pose import Finite
from mrts.base.formats.record import Record, Rule
from mrts.base.input_file import MAX_FILE_BYTES
from mrts.base.printable import printable
from mrts.base.regular_file import read_regular
from mrts.base.yaml_parser import yaml_text
from mrts.cell.number_paths import Keys, set_value
from mrts.kernel.cache_folder import cache_folder
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion
from mrts.studies.parameters import Parameter
from mrts.studies.sampling import SampleName, sample_points

VARIANT_FILES = "cell.yaml", "motion.yaml"
"""That a variant is written as."""


class StudyQuestion(Record):
    """What is asked of each variant.

    Attributes:
        profile: "constant" asks for the range of c², "optimal" for the fastest timing too.
        load: The question of an uncertain load, as in `mrts.scale`.
        reserve: Share of every limit that is kept free; None is the cell's own.
        between: Share of a limit by which it may be overstepped between the samples; None looks at the samples alone.
        clearance: Whether the least distance between bodies is wanted (`mrts.clearance`).
    """

    profile: Literal["constant", "optimal"] = "constant"
    load: Annotated[str, Rule(pattern=r"^(auto|nominal|guaranteed|possible|grid(:[0-9]{1,9})?)$")] = "auto"
    reserve: Annotated[float, Rule(ge=0, lt=1)] | None = None
    between: Finite | None = None
    clearance: bool = False


@dataclass(frozen=True)
class StudyFile:
    """A URDF or a mesh that a cell file names, so that a study can be solved where its files are not.

    Attributes:
        keys: Where the cell file names it, by `reference`.
        path: Where it is, absolute.
    """

    keys: Keys
    reference: str
    path: str
    content: bytes

    def named_in(self, folder: Path) -> str:
        """How a cell file in a folder names it."""
        return self.reference if is_uri(self.reference) else _reference(Path(self.path), folder)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Study:
    """Many variants of one cell and one motion. It pickles with all that a worker needs; equal studies ask the same.

    Attributes:
        path: The study file.
        folder: That the cell's URDFs are relative to.
        parameters: What varies, P of them.
        sample: "grid" or "sobol".
        variants: Number of variants.
        seed: Of what is drawn.
        question: What is asked of each variant.
        cell: Keys and values of the cell file, with those that are varied.
        motion: Keys and values of the motion file, likewise; a table's are where it is.
        table: The motion, where it is a table: no number of it varies.
        files: URDFs and mesh that the cell file names.
        digest: Hash of all that the answers depend on.
        limits: Further limits of the cell, as `mrts.Cell.with_limits` takes them.
    """

    path: Path
    folder: Path
    parameters: tuple[Parameter, ...]
    sample: SampleName
    variants: int
    seed: int
    question: StudyQuestion
    cell: dict[str, Any]
    motion: dict[str, Any]
    table: ObjectMotion | JointTable | None
    files: tuple[StudyFile, ...]
    digest: str
    limits: tuple[Callable[..., Any], ...] = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Study) and (other.digest, other.limits) == (self.digest, self.limits)

    def __hash__(self) -> int:
        return hash(self.digest)

    def __repr__(self) -> str:
        varied = ", ".join(parameter.path for parameter in self.parameters)
        return f"<Study of cell '{self.cell['name']}': {self.variants} variants ({self.sample}) of {varied}>"

    def with_limits(self, *limits: Callable[..., Any]) -> Self:
        """The same study of a cell with further limits; workers must be able to import them.

        Args:
            *limits: As `mrts.Cell.with_limits` takes them.

        Raises:
            InputError: If one is no function.
        """
        for limit in limits:
            check_callable("limits", limit)
        return replace(self, limits=limits)

    def points(self, first: int, last: int) -> Array:
        """Values of the parameters of some variants, the same whatever block they are asked for in.

        Args:
            first: The first variant.
            last: The first that is left out.

        Returns:
            Shape (V, P), in the units of the parameters.

        Raises:
            InputError: If there are no such variants.
        """
        check_type("first", first, int, np.integer)
        check_type("last", last, int, np.integer)
        if not 0 <= first <= last <= self.variants:
            rule = f"must be a block of the variants 0 to {self.variants}, the first one and the first left out."
            raise InputError("first, last", rule, value=(first, last))
        distributions = [parameter.distribution for parameter in self.parameters]
        if first == last:
            return np.empty((0, len(distributions)))
        return sample_points(distributions, self.sample, self.seed, (int(first), int(last)))

    def descriptions(self, point: Array) -> tuple[dict[str, Any], dict[str, Any]]:
        """Keys and values of the cell file and the motion file of a variant whose parameters are a point, Shape (P,).

        Raises:
            InputError: If these are something else.
        """
        values = as_array("point", point)
        if values.shape != (len(self.parameters),) or not np.all(np.isfinite(values)):
            rule = f"must be a finite number for each of {', '.join(each.path for each in self.parameters)}."
            raise InputError("point", rule, value=point)
        files = {"cell": deepcopy(self.cell), "motion": deepcopy(self.motion)}
        for parameter, value in zip(self.parameters, values.tolist(), strict=True):
            for target in parameter.targets:
                set_value(files, target.keys, target.value(value))
        return files["cell"], files["motion"]

    def at_hand(self) -> Self:
        """The same study with URDFs that are where it says, with the content that it was read with.

        It is itself where they still are; elsewhere, or where one has changed, they are written into the user's cache.
        """
        if all(_holds(Path(file.path), file.content) for file in self.files):
            return self
        folder, cell = cache_folder("studies", self.digest), deepcopy(self.cell)
        for number, file in enumerate(self.files):
            path = folder / f"{number}{Path(file.path).suffix}"
            if not _holds(path, file.content):
                write_atomically(path, partial(_write, content=file.content), private=True)
            set_value(cell, file.keys, path.name)
        return replace(self, folder=folder, cell=cell)

    def write_variant(self, index: int, folder: Path | str) -> tuple[Path, Path]:
        """Write one variant as files that `mrts scale` reads: cell.yaml and motion.yaml.

        Args:
            index: The variant, from 0.
            folder: For the files; made if it is missing. Comments of the study's own files are not in them.

        Returns:
            The cell file and the motion file.

        Raises:
            InputError: If there is no such variant or the folder cannot be written.
        """
        check_type("index", index, int, np.integer)
        if not 0 <= index < self.variants:
            raise InputError("index", f"must be a variant, from 0 to {self.variants - 1}.", value=index)
        folder = as_path("folder", folder)
        index = int(index)
        cell, motion = self.descriptions(self.points(index, index + 1)[0])
        for key in ("file", "joints"):
            if key in motion:
                motion[key] = _reference(Path(motion[key]), folder)
        cell_file, motion_file = (folder / name for name in VARIANT_FILES)
        heading = f"# Variant {index} of {printable(self.path.name)}\n"
        texts = heading + self.cell_text(cell, folder), heading + yaml_text(motion)
        write_together({cell_file: text_writer(texts[0]), motion_file: text_writer(texts[1])})
        return cell_file, motion_file

    def cell_text(self, keys: dict[str, Any], folder: Path) -> str:
        """The text of a cell file with some keys, in a folder that paths of its files are relative to."""
        written = deepcopy(keys)
        for file in self.files:
            set_value(written, file.keys, file.named_in(folder))
        return yaml_text(written)


def _write(path: Path, content: bytes) -> None:
    path.write_bytes(content)


def _holds(path: Path, content: bytes) -> bool:
    try:
        return read_regular(path, "input file", MAX_FILE_BYTES) == content
    except InputError:
        return False


def _reference(file: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(file, folder.resolve())).as_posix()
    except ValueError:  # another drive, or no path at all, which writing refuses
        return str(file)

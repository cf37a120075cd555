# SPDX-License-Identifier: MIT
"""The best variants of a study, solved again in full and written as files."""

import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mrts.cell.loading import load_cell
from mrts.motion.motion_file import load_motion
from mrts.scaling.result import ScalingResult
from mrts.scaling.scale import scale
from mrts.studies.ranking import fastest_first
from mrts.studies.study import VARIANT_FILES, Study
from mrts.studies.study_folder import StudyFolder
from mrts.studies.variant_rows import limit_text, range_row
from mrts.timing.result import RetimingResult
from mrts.timing.retime import retime

BEST_FOLDER = re.compile(r"best-\d+")


@dataclass(frozen=True)
class BestVariant:
    """A variant, solved again with the limits kept between the samples.

    Attributes:
        variant: Its number.
        numbers: What varies, as text: path, value and unit.
        files: Its cell file and its motion file.
        result: Of `mrts.scale`, or of `mrts.retime` where the study asks for the fastest timing.
    """

    variant: int
    numbers: tuple[str, ...]
    files: tuple[Path, Path]
    result: ScalingResult | RetimingResult

    @property
    def constant(self) -> ScalingResult:
        """The result of the constant factor, for its range."""
        return self.result.factor if isinstance(self.result, RetimingResult) else self.result

    @property
    def duration(self) -> float | None:
        """Of the fastest motion [s], with some load where it is asked what is possible; None where there is none."""
        if isinstance(self.result, RetimingResult):
            return self.result.duration
        if self.result.load is not None and self.result.load.question == "possible":
            return range_row(self.result.range, float(self.result.motion.object.time[-1])).get("duration")
        return None if self.result.trajectory is None else self.result.trajectory.duration

    @property
    def limit(self) -> str:
        """What binds at c²⁺ of the constant factor, or why there is none."""
        upper = self.constant.range.upper
        if upper is None or upper.time is None:
            return self.constant.range.explain() or self.constant.range.status.value
        return limit_text(upper.rows, upper.time, upper.load)


def write_best(study: Study, folder: StudyFolder, count: int) -> list[BestVariant]:
    """Write the best variants as files into folders best-1, best-2, … and solve them again from there.

    What an earlier call wrote there goes, so that no more are left than are asked for.

    Args:
        study: The study.
        folder: Its rows.
        count: How many, where there are as many.

    Raises:
        InputError: If a file cannot be written.
    """
    best = []
    _remove_best(folder.path)
    for rank, variant in enumerate(fastest_variants(folder, count), start=1):
        files = study.write_variant(variant, folder.path / f"best-{rank}")
        point = study.points(variant, variant + 1)[0]
        shown = (
            f"{each.path} = {value:.6g}{f' {each.unit}' if each.unit else ''}"
            for each, value in zip(study.parameters, point, strict=True)
        )
        best.append(BestVariant(variant, tuple(shown), files, _solved_again(study, *files)))
    return best


def fastest_variants(folder: StudyFolder, count: int) -> list[int]:
    """Numbers of the variants of least duration, the least first; of equals the lower number.

    Args:
        folder: The rows.
        count: How many, where there are as many.
    """
    rows = folder.table(["variant", "duration"])
    variant, duration = np.asarray(rows["variant"], dtype=int), np.asarray(rows["duration"], dtype=np.float64)
    best: list[int] = variant[fastest_first(variant, duration)[:count]].tolist()
    return best


def _remove_best(folder: Path) -> None:
    """Remove the files of the best variants, and their folders where nothing else is in them."""
    for path in folder.glob("best-*"):
        if not BEST_FOLDER.fullmatch(path.name) or path.is_symlink():
            continue
        with suppress(OSError):  # writing says what cannot be written
            for name in VARIANT_FILES:
                (path / name).unlink(missing_ok=True)
            path.rmdir()


def best_lines(best: list[BestVariant], folder: Path) -> Iterator[str]:
    """The best variants as a table for people.

    Args:
        best: From `write_best`.
        folder: Of the study, which their files lie in.
    """
    yield "the best, solved again with limits kept between the samples:"
    yield f"{'rank':>4}  {'variant':>8}  {'duration':>10}  {'c²⁺':>9}  limited by"
    for rank, each in enumerate(best, start=1):
        upper = each.constant.range.upper
        c2 = "-" if upper is None or not np.isfinite(upper.c2) else f"{upper.c2:#.4g}"
        duration = "-" if each.duration is None else f"{each.duration:#.4g} s"
        yield f"{rank:>4}  {each.variant:>8}  {duration:>10}  {c2:>9}  {each.limit}"
        yield f"{'':6}{each.files[0].relative_to(folder)}: {', '.join(each.numbers)}"


def _solved_again(study: Study, cell_file: Path, motion_file: Path) -> ScalingResult | RetimingResult:
    cell, motion = load_cell(cell_file).with_limits(*study.limits), load_motion(motion_file)
    question = study.question
    solve = retime if question.profile == "optimal" else scale
    return solve(cell, motion, load=question.load, reserve=question.reserve)

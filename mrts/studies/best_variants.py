# SPDX-License-Identifier: MIT
"""The best variants of a study, solved again between the samples too and written as files."""

import re
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from mrts.program.excess import BETWEEN
from mrts.studies.study import VARIANT_FILES, Study
from mrts.studies.study_folder import StudyFolder
from mrts.studies.variant_rows import fastest_first, solved_row

BEST_FOLDER = re.compile(r"best-\d+")


def write_best(study: Study, folder: StudyFolder, count: int) -> list[str]:
    """Write the best variants as files into folders best-1, best-2, … and solve them again.

    What an earlier call wrote there goes, so that no more are left than are asked for.

    Returns:
        A table of them for people.

    Raises:
        InputError: If a file cannot be written.
    """
    lines = ["the best, solved again with limits kept between the samples:"]
    lines.append(f"{'rank':>4}  {'variant':>8}  {'duration':>10}  {'c²⁺':>9}  limited by")
    _remove_best(folder.path)
    rows = folder.table(["variant", "duration"])
    variants, durations = np.asarray(rows["variant"], dtype=int), np.asarray(rows["duration"], dtype=np.float64)
    finer = replace(study.at_hand(), question=study.question.model_copy(update={"between": BETWEEN}))
    for rank, variant in enumerate(variants[fastest_first(variants, durations)[:count]].tolist(), start=1):
        file, _ = study.write_variant(variant, folder.path / f"best-{rank}")
        point = study.points(variant, variant + 1)[0]
        row = solved_row(finer, point)
        c2, duration = (row.get(name) for name in ("c2_upper", "duration"))
        texts = "-" if duration is None else f"{duration:#.4g} s", "-" if c2 is None else f"{c2:#.4g}"
        limit, time = (row.get(name) for name in ("upper_limit", "upper_time"))
        limit = row.get("reason") if limit is None else f"{limit} at t = {time:.4g} s"
        varied = zip(study.parameters, point, strict=True)
        numbers = ", ".join(f"{each.path} = {value:.6g} {each.unit}".rstrip() for each, value in varied)
        lines.append(f"{rank:>4}  {variant:>8}  {texts[0]:>10}  {texts[1]:>9}  {limit}")
        lines.append(f"{'':6}{file.relative_to(folder.path)}: {numbers}")
    return lines


def _remove_best(folder: Path) -> None:
    for path in folder.glob("best-*"):
        if not BEST_FOLDER.fullmatch(path.name) or path.is_symlink():
            continue
        with suppress(OSError):  # writing says what cannot be written
            for name in VARIANT_FILES:
                (path / name).unlink(missing_ok=True)
            path.rmdir()

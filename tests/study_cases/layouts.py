"""Studies of layouts: files, and what `mrts.scale` says of a layout by itself."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

import mrts
from mrts.base.arrays import Array
from mrts.motion.motion_file import MotionDescription, sample_motion
from mrts.studies.place import LayoutSearch

DATA = Path(mrts.__file__).parent / "data"

STEP = 1e-4
"""To either side, by which the program of a step is asked [m, rad]: it is linear there but for kinks."""


def write_study(folder: Path, cell: Path | dict[str, Any], motion: Path, vary: dict[str, Any], **keys: Any) -> Path:
    """A study file, and the cell file where its keys are given."""
    if isinstance(cell, dict):
        (folder / "cell.yaml").write_text(yaml.safe_dump(cell), encoding="utf-8")
        cell = folder / "cell.yaml"
    keys = {"cell": str(cell), "motion": str(motion), "vary": vary, "sample": "sobol", "count": 16} | keys
    (folder / "study.yaml").write_text(yaml.safe_dump(keys), encoding="utf-8")
    return folder / "study.yaml"


@dataclass(frozen=True)
class Layouts:
    """A study of layouts and its motion."""

    study: mrts.Study
    motion: mrts.ObjectMotion

    @classmethod
    def of(cls, path: Path) -> "Layouts":
        """Those of a study file."""
        study = mrts.read_study(path)
        return cls(study, sample_motion(MotionDescription(**study.motion)))

    def c2(self, values: Array) -> float:
        """c²⁺ of a layout as `mrts.scale` finds it at the samples alone; minus infinity where it cannot be played."""
        keys, asked = self.study.descriptions(values)[0], self.study.question
        try:
            cell = mrts.Cell.from_description(keys, folder=self.study.folder)
            return mrts.scale(cell, self.motion, load=asked.load, reserve=asked.reserve, between=None).range.c2_upper
        except mrts.MrtsError:
            return -np.inf

    def slope(self, values: Array) -> Array:
        """What the program of a step says of the change of ln c²⁺, Shape (P,)."""
        search = LayoutSearch(self.study)
        layout = search.tried(values)
        assert layout is not None
        program = search.program(layout)
        promised = [[program(side * step, side * step)[1] for side in (1, -1)] for step in STEP * np.eye(len(values))]
        return np.log(promised) @ [1, -1] / (2 * STEP)

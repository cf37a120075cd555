# SPDX-License-Identifier: MIT
"""What a saved result says in words: the JSON text beside its arrays, see docs/saved_results.md."""

import json
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, FailFast, Field, ValidationError, model_validator

from mrts.base.errors import InputError
from mrts.base.load_box import PARAMETERS, LoadBox
from mrts.base.manifest import FORMAT, LOAD_ENTRIES, Matrix, Matrix3, Vector3
from mrts.base.remark import Severity
from mrts.cell.cell_change import ChangeKind
from mrts.cell.record import CellManifest
from mrts.limits.rows import ActiveRow, RowName
from mrts.program.formulation import DistributionName, FormulationName
from mrts.program.range_status import RangeStatus

FORMAT_NAME = "mrts result"

VERSION = 7
"""Of arrays and description together; any change of either, or of the manifest's format, raises it."""

DESCRIPTION_BYTES = 5_000_000
DESCRIPTION_RATIO = 20
"""The words of a result take at most so many bytes, or so many times its file: parsed, they are a dozen times larger.
They shrink to about a sixth where many samples are infeasible."""

DAMAGED = "The file is damaged: save the result again."

LARGEST_SAVED = 1e60
"""Above what follows from any input (`mrts.base.input_file.LARGEST_NUMBER`), and products of several stay finite."""

Index = Annotated[int, Field(ge=0, lt=2**31)]
Parameter = Annotated[str, Field(pattern=f"^({'|'.join(PARAMETERS)})$")]
LoadVector = Annotated[list[float], Field(min_length=len(LOAD_ENTRIES), max_length=len(LOAD_ENTRIES))]


class _Record(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class RowEntry(_Record):
    """A row at one of its limits, as `mrts.limits.rows.ActiveRow`."""

    kind: str
    robot: str
    element: str
    unit: str
    side: Literal["lower", "upper"]
    limit: float

    def row(self) -> ActiveRow:
        """The row."""
        return ActiveRow(RowName(self.kind, self.robot, self.element, self.unit), self.side, self.limit)


class LoadEntry(_Record):
    """One load of a box, as `mrts.base.load_box.LoadPoint`."""

    parameters: dict[Parameter, float]
    load: LoadVector


class BoxEntry(_Record):
    """A box of loads, as `mrts.base.load_box.LoadBox`."""

    mass: Annotated[float, Field(gt=0)]
    inertia: Matrix3
    ranges: dict[Parameter, tuple[float, float]]
    outer_hull: bool
    principal_axes: Matrix3
    principal_moments: Vector3

    @classmethod
    def of(cls, box: LoadBox) -> "BoxEntry":
        """The entry of a box."""
        return cls(
            mass=box.mass,
            inertia=box.inertia.tolist(),
            ranges=dict(box.ranges),
            outer_hull=box.outer_hull,
            principal_axes=box.principal_axes.tolist(),
            principal_moments=box.principal_moments.tolist(),
        )

    def box(self) -> LoadBox:
        """The box.

        Raises:
            InputError: If it breaks a rule.
        """
        box = LoadBox(self.mass, np.array(self.inertia), self.ranges, self.outer_hull)
        return box.with_axes(np.array(self.principal_axes), np.array(self.principal_moments))


class StudyEntry(_Record):
    """What was asked of an uncertain load; its points are indices of `Description.loads`."""

    question: Annotated[str, Field(pattern=r"^(guaranteed|possible|grid(:[0-9]+)?)$")]
    box: BoxEntry
    points: list[Index]
    not_converged: list[Index]

    @model_validator(mode="after")
    def _grid_of_masses(self) -> Self:
        if self.question.startswith("grid") and "mass" not in self.box.ranges:
            raise ValueError("a grid runs along the mass")
        return self


class ConflictEntry(_Record):
    """An infeasible sample of one range, as `mrts.program.infeasibility.Conflict`; rows and load are indices."""

    range: Index
    sample: Index
    rows: list[Index]
    multipliers: list[float]
    widening: float
    moves: list[float]
    load: Index | None
    c2: Annotated[float, Field(ge=0)] | None = None

    @model_validator(mode="after")
    def _one_of_each_a_row(self) -> Self:
        if not len(self.rows) == len(self.multipliers) == len(self.moves):
            raise ValueError("rows, multipliers and moves must be of one length")
        return self


class SharingEntry(_Record):
    """A fixed distribution, as `mrts.program.load_sharing.LoadSharing`."""

    shares: list[float] | None
    internal_wrench: list[float] | Matrix | None


Rate = Annotated[float, Field(gt=0)]


class RatesEntry(_Record):
    """Limits of rates, as `mrts.program.rate_limits.RateLimits`; None is unbounded."""

    torque: list[Rate | None]
    wrench: list[Rate | None]
    jerk: list[Rate | None]


class EndEntry(_Record):
    """An end of a range within rates, as `mrts.scaling.range.RangeEnd`; rows and load are indices, None is no limit."""

    c2: Annotated[float, Field(ge=0)] | None
    sample: Index | None
    rows: list[Index]
    load: Index | None

    @model_validator(mode="after")
    def _somewhere(self) -> Self:
        if (self.c2 is None) != (self.sample is None):
            raise ValueError("an end without a c2 must be at no sample, and only such an end")
        return self


class RatedEntry(_Record):
    """A range within rates, as `mrts.scaling.range.ScalingRange`."""

    status: RangeStatus
    ends: tuple[EndEntry, EndEntry]

    @model_validator(mode="after")
    def _agrees(self) -> Self:
        lower, upper = self.ends
        if lower.c2 is None:
            raise ValueError("a lower end must have a c2")
        if self.status is RangeStatus.INFEASIBLE:
            raise ValueError("an infeasible motion has no range within rates")
        if (self.status is RangeStatus.UNBOUNDED) != (upper.c2 is None):
            raise ValueError("an upper end must have a c2, unless the range is unbounded")
        return self


class RuleEntry(_Record):
    """How torques are distributed, as `mrts.scaling.options.Options`."""

    sharing: SharingEntry | None
    formulation: FormulationName
    weights: float | list[float] | Matrix | None
    distribute: DistributionName = "least-torque"
    rates: RatesEntry | None = None


class ReserveEntry(_Record):
    """By how much limits may shrink, as `mrts.program.reserve.Reserve`; rows and load are indices."""

    share: Annotated[float, Field(ge=0, le=1)]
    sample: Index
    rows: list[Index]
    load: Index | None


class PlanReserveEntry(_Record):
    """What is left of the limits, as `mrts.program.reserve.PlanReserve`."""

    whole: ReserveEntry
    distributed: ReserveEntry | None


class WarningEntry(_Record):
    """What to know before trusting the result, as `mrts.base.remark.Remark`."""

    code: str
    severity: Severity = "warning"
    text: str
    sample: Index | None


class ExcessEntry(_Record):
    """How far limits are overstepped between the samples, as `mrts.program.excess.Excess`; the row is an index."""

    share: Annotated[float, Field(ge=0)]
    tolerance: Annotated[float, Field(gt=0)]
    time: float | None
    row: Index | None


class AnswerEntry(_Record):
    """How fast a motion may be played with a cell, as `mrts.scaling.what_if.SpeedAnswer`; null is none, or infinity."""

    status: str
    c2: Annotated[float, Field(ge=0)] | None
    duration: Annotated[float, Field(gt=0)] | None
    limits: list[str]
    reason: str


class ChangeEntry(_Record):
    """A change and what it does, as `mrts.scaling.what_if.ChangedAnswer`."""

    kind: ChangeKind
    robot: str
    element: str
    step: float
    after: AnswerEntry


class WhatIfEntry(_Record):
    """What changes to the cell would do, as `mrts.scaling.what_if.WhatIf`."""

    share: float
    shift: float
    turn: float
    before: AnswerEntry
    changes: list[ChangeEntry]
    left_out: str


class Description(_Record):
    """Everything of a saved result that is not a number a sample; docs/saved_results.md has the meaning of each."""

    format: Literal["mrts result"]
    version: Literal[7]
    mrts_version: str
    manifest: CellManifest
    load: LoadVector
    load_box: BoxEntry | None
    enforces_velocity_limits: bool
    rule: RuleEntry
    c2: Annotated[float, Field(gt=0)] | None
    fallbacks: Index
    range_fallbacks: Annotated[list[Index], Field(min_length=1)]
    several: list[bool]
    study: StudyEntry | None
    origin: str
    warnings: Annotated[list[WarningEntry], FailFast()]
    rows: Annotated[list[RowEntry], FailFast()]
    limits: Annotated[list[str], FailFast()] = []
    kept_reserve: Annotated[float, Field(ge=0, lt=1)] = 0.0
    reserve: PlanReserveEntry | None = None
    loads: Annotated[list[LoadEntry], FailFast()]
    conflicts: Annotated[list[ConflictEntry], FailFast()]
    excess: ExcessEntry | None = None
    rated: RatedEntry | None = None
    what_if: WhatIfEntry | None = None

    def text(self) -> str:
        """As JSON."""
        usual = set() if self.limits else {"limits"}
        return json.dumps(self.model_dump(mode="json", exclude=usual), allow_nan=False, ensure_ascii=False)


def read_description(path: Path, text: bytes) -> Description:
    """Read and validate the description of a saved result.

    Args:
        path: The file, for messages.
        text: UTF-8.

    Raises:
        InputError: If it is none, of a newer version, or breaks a rule of the format.
    """
    try:
        data: Any = json.loads(text)
    except (ValueError, RecursionError):
        data = None
    if not isinstance(data, dict) or data.get("format") != FORMAT_NAME:
        raise InputError(path, "is no saved result of mrts. Make one with mrts.save_result or `mrts scale --save`.")
    version = data.get("version")
    if version != VERSION:
        newer = isinstance(version, int) and version > VERSION
        advice = "Update mrts to read it." if newer else "Save the result again."
        raise InputError(
            path,
            f"this mrts reads version {VERSION}; the file was written by mrts {data.get('mrts_version')}. {advice}",
            key="version",
            value=version,
        )
    _check_sizes(path, data)
    try:
        description = Description.model_validate(data)
    except ValidationError as error:
        first = error.errors()[0]
        inner = first.get("ctx", {}).get("error")
        keys = (*first["loc"], *([inner.key] if isinstance(inner, InputError) else ()))
        key = ".".join(str(part) for part in keys if part != "")
        raise InputError(path, f"{first['msg'].rstrip('.')}. {DAMAGED}", key=key) from None
    manifest = description.manifest
    if manifest.format != FORMAT or manifest.content_sha256 != manifest.content_hash():
        raise InputError(path, "was edited after it was saved. Save the result again.", key="manifest")
    return description


def _check_sizes(path: Path, data: dict[str, Any]) -> None:
    """Refuse numbers that no result holds: they overflow where the result is shown."""
    left: list[tuple[str, Any]] = list(data.items())
    while left:
        key, value = left.pop()
        if isinstance(value, dict):
            left += [(f"{key}.{name}", inner) for name, inner in value.items()]
        elif isinstance(value, list):
            left += [(f"{key}.{place}", inner) for place, inner in enumerate(value)]
        elif isinstance(value, int | float) and abs(value) > LARGEST_SAVED:
            raise InputError(path, f"must be at most {LARGEST_SAVED:.0e} in size. {DAMAGED}", key=key, value=value)

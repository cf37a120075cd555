# SPDX-License-Identifier: MIT
"""`vary` of the study file: each parameter of a study is a distribution and the numbers that its value moves."""

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from mrts.base.errors import InputError
from mrts.base.formats.pose import Finite
from mrts.base.formats.record import Record, Rule
from mrts.base.input_file import IDENTIFIER, LONGEST_NAME
from mrts.cell.cell import Cell
from mrts.cell.number_paths import (
    Keys,
    find_keys,
    number_unit,
    numbers_below,
    path_text,
    value_at,
    with_place,
)
from mrts.studies.sampling import MAX_STEPS, Distribution, SampleName

ANSWERS = dict.fromkeys(("status", "reason", "lower_limit", "upper_limit"), "string")
ANSWERS |= dict.fromkeys(("c2_lower", "c2_upper", "lower_time", "upper_time", "duration"), "float64")
"""Columns of every study behind the number of a variant and what varies, and their types."""

RESERVED_NAMES = ("variant", *ANSWERS, "clearance")
"""Columns of a study's table beside those of its parameters."""

MOVES = ("sets", "shifts", "scales")
"""What a parameter can do to a number: be it, be added to it, multiply it."""

FORMS = "a list such as [1, 2, 3], a range such as {from: 1, to: 3, steps: 5}, or {normal: {mean: 2, std: 0.1}}"

PATHS_SHOWN = 3
"""Of what a parameter moves."""


@dataclass(frozen=True)
class Target:
    """A number, by its path and the same as keys, that a parameter sets to offset + factor × its own value."""

    path: str
    keys: Keys
    unit: str
    factor: float = 1.0
    offset: float = 0.0

    def value(self, at: float) -> float:
        """The number where the parameter has a value."""
        return self.offset + self.factor * at


@dataclass(frozen=True)
class Parameter:
    """What a study varies: one number, or several that move together.

    `path` is that of the number, or the name of what moves several; it heads a column. A unit may be empty.
    """

    path: str
    unit: str
    distribution: Distribution
    targets: tuple[Target, ...]

    def __str__(self) -> str:
        paths = [target.path for target in self.targets]
        more = f" and {len(paths) - PATHS_SHOWN} more" if len(paths) > PATHS_SHOWN else ""
        moved = "" if paths == [self.path] else f" ({', '.join(paths[:PATHS_SHOWN])}{more})"
        return f"{self.path}{moved}: {self.distribution.text(self.unit)}"


class NormalDescription(Record):
    """Mean and standard deviation of a normal distribution."""

    mean: Finite
    std: Annotated[float, Rule(gt=0)]


Paths = Annotated[list[str], Rule(min_length=1)]
Factors = Annotated[dict[str, Finite], Rule(min_length=1)]


class ParameterDescription(Record):
    """An entry of `vary` that is no list; without `sets`, `shifts` and `scales` it is itself the path to a number."""

    from_: Finite | None = None
    to: Finite | None = None
    steps: Annotated[int, Rule(ge=2, le=MAX_STEPS)] | None = None
    values: Annotated[list[Finite], Rule(min_length=1)] | None = None
    normal: NormalDescription | None = None
    sets: Paths | Factors | None = None
    shifts: Paths | Factors | None = None
    scales: Paths | None = None

    def problem(self) -> str:
        """The rule that its keys break with each other; empty if none."""
        ends = [name for name, value in (("from", self.from_), ("to", self.to)) if value is not None]
        forms = ["a range"] if ends or self.steps is not None else []
        forms += [name for name in ("values", "normal") if getattr(self, name) is not None]
        if len(forms) != 1:
            return f"one way to vary it belongs here: {FORMS}; here are {', '.join(forms) or 'none of them'}"
        if self.from_ is not None and self.to is not None:
            ends_given = f"here are {self.from_:g} and {self.to:g}"
            return "" if self.from_ < self.to else f"'from' must be below 'to'; {ends_given}"
        if forms == ["a range"]:
            return f"a range needs 'from' and 'to'; here is {ends[0] if ends else 'steps alone'}"
        repeated = [value for value, count in Counter(self.values or []).items() if count > 1]
        return f"{repeated[0]:g} stands twice; each value belongs here once" if repeated else ""

    def distribution(self, sample: SampleName) -> Distribution:
        """How it is distributed.

        Raises:
            InputError: If the two do not go together.
        """
        if sample != "grid" and self.steps is not None:
            rule = f"steps are those of a grid; sample: {sample} draws from the whole range. Leave this out"
            raise InputError("", f"{rule}.", key="steps", value=self.steps)
        if self.values is not None:
            return Distribution("values", tuple(self.values))
        if self.steps is not None:
            return Distribution("steps", tuple(np.linspace(self.from_ or 0, self.to or 0, self.steps).tolist()))
        if sample == "grid":
            rule = "a grid needs to know in how many steps, such as steps: 5"
            if self.normal is not None:
                rule = "a normal distribution has no steps to make a grid of"
            raise InputError("", f"{rule}. Take sample: sobol with a count.")
        if self.normal is not None:
            return Distribution("normal", (self.normal.mean, self.normal.std))
        return Distribution("uniform", (self.from_ or 0.0, self.to or 0.0))


def read_parameters(
    path: Path,
    vary: Mapping[str, Any],
    sample: SampleName,
    given: dict[str, Any],
    filled: dict[str, Any],
    cell: Cell,
) -> tuple[Parameter, ...]:
    """The parameters of a study, whose file is named in messages, by its key `vary`.

    Numbers that vary are written into the keys and values of the "cell" and the "motion" file that were given; `filled`
    are the same with all that they leave out.

    Raises:
        InputError: If an entry breaks a rule, leads to no number, or to one that another entry moves.
    """
    if not vary:
        raise InputError(path, "names nothing to vary, such as object.mass: [2, 3, 4].", key="vary")
    parameters = []
    movers: dict[Keys, str] = {}
    for name, value in vary.items():
        try:
            parameter = _parameter(name, value, sample, filled, cell)
            for target in parameter.targets:
                _check_apart(name, target, movers)
                movers[target.keys] = name
        except InputError as error:
            raise error.inside(path, f"vary.{name}") from None
        parameters.append(parameter)
    for keys in movers:
        with_place(given, filled, keys)
    return tuple(parameters)


def _check_apart(mover: str, target: Target, movers: Mapping[Keys, str]) -> None:
    for keys, other in movers.items():
        shared = min(len(keys), len(target.keys))
        if keys[:shared] == target.keys[:shared]:
            by = f", by '{other}' and '{mover}'" if other != mover else ""
            raise InputError("", f"{target.path} is moved twice{by}. Each number has one mover.")


def _parameter(name: str, value: object, sample: SampleName, files: dict[str, Any], cell: Cell) -> Parameter:
    if isinstance(value, list):
        value = {"values": value}
    if not isinstance(value, dict):
        raise InputError("", f"must say how it varies: {FORMS}.", value=value)
    entry = ParameterDescription.model_validate(value)
    distribution = entry.distribution(sample)
    moves = {move: getattr(entry, move) for move in MOVES if getattr(entry, move) is not None}
    if moves:
        _check_name(name)
        targets = tuple(target for move, listed in moves.items() for target in _targets(move, listed, files, cell))
    else:
        targets = (_target(files, cell, name),)
    units = {target.unit for target in targets}
    unit = units.pop() if len(units) == 1 and "scales" not in moves else ""  # a factor has none
    return Parameter(name if moves else targets[0].path, unit, distribution, targets)


def _check_name(name: str) -> None:
    if not re.fullmatch(IDENTIFIER, name) or len(name) > LONGEST_NAME or name in RESERVED_NAMES:
        rule = (
            "is the name of a parameter that moves several numbers, and heads a column: letters, digits and single "
            f"underscores, at most {LONGEST_NAME}, and none of {', '.join(RESERVED_NAMES)}"
        )
        raise InputError("", f"{rule}.")


def _targets(move: str, listed: list[str] | dict[str, float], files: dict[str, Any], cell: Cell) -> Iterator[Target]:
    for path, factor in listed.items() if isinstance(listed, dict) else [(path, 1.0) for path in listed]:
        try:
            if factor == 0:
                raise InputError("", "a factor is not 0.", value=factor)  # noqa: TRY301
            if move == "sets":
                yield _target(files, cell, path, factor)
            else:
                yield from _moved(move, path, factor, files, cell)
        except InputError as error:
            raise error.inside("", f"{move}.{path}") from None


def _moved(move: str, path: str, factor: float, files: dict[str, Any], cell: Cell) -> Iterator[Target]:
    numbers = list(numbers_below(files, _keys(files, cell, path)))
    own = [float(value_at(files, number)) for number in numbers]
    if not own:
        rule = f"the cell and motion files give no number at {path}, so there is none to move. Write it there first"
        raise InputError("", f"{rule}.")
    if move == "scales" and not any(own):
        raise InputError("", f"what is at {path} is 0, and stays 0 however it is scaled. Use 'sets' or 'shifts'.")
    for number, value in zip(numbers, own, strict=True):
        yield _target(files, cell, number, *((value, 0.0) if move == "scales" else (factor, value)))


def _keys(files: dict[str, Any], cell: Cell, path: str) -> Keys:
    try:
        return find_keys(files, [len(robot.joints) for robot in cell.robots], path)
    except InputError as error:
        raise InputError("", error.rule, value=path) from None


def _target(files: dict[str, Any], cell: Cell, place: str | Keys, factor: float = 1.0, offset: float = 0.0) -> Target:
    """One number; a place that holds none, but may, is one."""
    keys = _keys(files, cell, place) if isinstance(place, str) else place
    text, value = path_text(files, keys), value_at(files, keys)
    if isinstance(value, dict | list):
        inside = next(numbers_below(files, keys), None)
        advice = "" if inside is None else f": name one of its numbers, such as {path_text(files, inside)}"
        raise InputError("", f"{text} is no number{advice}.")
    if isinstance(value, str | bool):
        raise InputError("", f"{text} is '{value}', which is no number; numbers vary.")
    if keys == ("motion", "samples"):
        raise InputError("", f"{text} says how finely the motion is looked at, and does not vary.")
    return Target(text, keys, number_unit(keys, cell.robots, cell.wrench_units), factor, offset)

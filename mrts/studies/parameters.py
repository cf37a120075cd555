# SPDX-License-Identifier: MIT
"""`vary` of the study file: parameters, each a distribution and the numbers that it moves.

Points are those of a grid or of a Sobol sequence, any block by itself.
"""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.record import Finite, Record, Rule
from mrts.base.input_file import IDENTIFIER, LONGEST_NAME
from mrts.base.words import first_names
from mrts.cell.cell import Cell
from mrts.cell.cell_keys import Keys, find_keys, number_unit, numbers_below, path_text, value_at, with_place

SampleName = Literal["grid", "sobol"]

MAX_VARIANTS = 100_000_000
"""At a thousand a second and core a day of one core."""

MAX_STEPS = 100_000
"""Of one number in a grid."""

NEAREST_TO_CERTAIN = 1e-16
"""Least distance of a probability from 0 and 1: a distribution without ends has no number there."""

VALUES_SHOWN = 6
"""Of a list."""

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
class Distribution:
    """The values of a parameter.

    Attributes:
        kind: "values" and "steps" (of a range) are levels, one as likely as another; "uniform"; "normal", of numbers
            that happen and are not for a designer to choose.
        numbers: The levels, in the order in which a grid takes them; least and largest value; mean and standard
            deviation.
    """

    kind: str
    numbers: tuple[float, ...]

    @property
    def levels(self) -> tuple[float, ...] | None:
        """The values where they can be counted; None where they cannot."""
        return self.numbers if self.kind in {"values", "steps"} else None

    def at(self, probability: Array) -> Array:
        """The values that probabilities from 0 to 1 stand for, of the same Shape."""
        if self.levels is not None:
            places = (probability * len(self.levels)).astype(np.intp)
            return np.array(self.levels)[np.minimum(places, len(self.levels) - 1)]
        first, second = self.numbers
        if self.kind == "uniform":
            return first + probability * (second - first)
        from scipy.special import ndtri  # noqa: PLC0415 (slow to import, and most studies have no such number)

        quantile: Array = ndtri(np.clip(probability, NEAREST_TO_CERTAIN, 1 - NEAREST_TO_CERTAIN))
        return first + second * quantile

    def text(self, unit: str) -> str:
        """The distribution for people, with the unit of its values, which may be empty."""
        spaced, shown = unit and f" {unit}", [f"{number:g}" for number in self.numbers]
        if self.kind == "steps":
            return f"from {shown[0]} to {shown[-1]}{spaced} in {len(shown)} steps"
        if self.kind == "values":
            more = f", … ({len(shown)} values)" if len(shown) > VALUES_SHOWN else ""
            return f"{', '.join(shown[:VALUES_SHOWN])}{more}{spaced}"
        if self.kind == "normal":
            return f"normal, around {shown[0]}, standard deviation {shown[1]}{spaced}"
        return f"from {shown[0]} to {shown[1]}{spaced}"


@dataclass(frozen=True)
class Target:
    """A number, by its path and the same as keys, that a parameter sets to offset + factor × its own value."""

    path: str
    keys: Keys
    unit: str
    factor: float = 1.0
    offset: float = 0.0


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
        moved = "" if paths == [self.path] else f" ({first_names(paths, PATHS_SHOWN)})"
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
        if not re.fullmatch(IDENTIFIER, name) or len(name) > LONGEST_NAME or name in RESERVED_NAMES:
            rule = (
                "is the name of a parameter that moves several numbers, and heads a column: letters, digits and single "
                f"underscores, at most {LONGEST_NAME}, and none of {', '.join(RESERVED_NAMES)}"
            )
            raise InputError("", f"{rule}.")
        targets = tuple(target for move, listed in moves.items() for target in _targets(move, listed, files, cell))
    else:
        targets = (_target(files, cell, name),)
    units = {target.unit for target in targets}
    unit = units.pop() if len(units) == 1 and "scales" not in moves else ""  # a factor has none
    return Parameter(name if moves else targets[0].path, unit, distribution, targets)


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
    numbers = list(numbers_below(files, _keys(files, path)))
    own = [float(value_at(files, number)) for number in numbers]
    if not own:
        rule = f"the cell and motion files give no number at {path}, so there is none to move. Write it there first"
        raise InputError("", f"{rule}.")
    if move == "scales" and not any(own):
        raise InputError("", f"what is at {path} is 0, and stays 0 however it is scaled. Use 'sets' or 'shifts'.")
    for number, value in zip(numbers, own, strict=True):
        yield _target(files, cell, number, *((value, 0.0) if move == "scales" else (factor, value)))


def _keys(files: dict[str, Any], path: str) -> Keys:
    try:
        return find_keys(files, path)
    except InputError as error:
        raise InputError("", error.rule, value=path) from None


def _target(files: dict[str, Any], cell: Cell, place: str | Keys, factor: float = 1.0, offset: float = 0.0) -> Target:
    """One number; a place that holds none, but may, is one."""
    keys = _keys(files, place) if isinstance(place, str) else place
    text, value = path_text(files, keys), value_at(files, keys)
    if isinstance(value, dict | list):
        inside = next(numbers_below(files, keys), None)
        advice = "" if inside is None else f": name one of its numbers, such as {path_text(files, inside)}"
        raise InputError("", f"{text} is no number{advice}.")
    if isinstance(value, str | bool):
        raise InputError("", f"{text} is '{value}', which is no number; numbers vary.")
    if keys == ("motion", "samples"):
        raise InputError("", f"{text} says how finely the motion is looked at, and does not vary.")
    return Target(text, keys, number_unit(keys, cell), factor, offset)


def sample_points(
    distributions: Sequence[Distribution], sample: SampleName, seed: int, block: tuple[int, int]
) -> Array:
    """The points of a study from a first to a last that is left out, Shape (V, P), the same whatever block they are in.

    "grid" takes every combination of levels, the last number varying fastest; "sobol" is a scrambled Sobol sequence
    (`scipy.stats.qmc`), drawn with a seed.
    """
    first, last = block
    if sample == "grid":
        return _grid([np.array(each.levels) for each in distributions], first, last)
    drawn = _sobol(len(distributions), seed, first, last).T
    return np.column_stack([each.at(column) for each, column in zip(distributions, drawn, strict=True)])


def _grid(values: Sequence[Array], first: int, last: int) -> Array:
    """Points of a grid, Shape (V, P); of numpy's index functions none takes more than 64 numbers."""
    left = np.arange(first, last)
    columns = []
    for levels in reversed(values):
        left, place = np.divmod(left, len(levels))
        columns.append(levels[place])
    return np.column_stack(columns[::-1])


def _sobol(numbers: int, seed: int, first: int, last: int) -> Array:
    from scipy.stats import qmc  # noqa: PLC0415 (slow to import)

    engine = qmc.Sobol(numbers, rng=np.random.default_rng(seed))
    if first > 0:
        engine.fast_forward(first)
        return np.asarray(engine.random(last - first))
    start = engine.random(min(last, 1))  # by itself: a first block that is no power of 2 would be warned of
    return np.vstack([start, engine.random(last - 1)]) if last > 1 else np.asarray(start)

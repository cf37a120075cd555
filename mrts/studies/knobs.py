# SPDX-License-Identifier: MIT
"""`vary` of the study file: which numbers each entry moves, and how it is spread."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mrts.base.argument_types import is_number
from mrts.base.errors import InputError
from mrts.base.input_file import IDENTIFIER, LARGEST_NUMBER, LONGEST_NAME
from mrts.cell.cell import Cell
from mrts.studies.knob_spread import KnobDescription, knob_spread, read_knob
from mrts.studies.number_paths import (
    Keys,
    PathError,
    find_keys,
    number_unit,
    numbers_below,
    path_text,
    value_at,
    with_place,
)
from mrts.studies.sampling import SampleName
from mrts.studies.spreads import Levels, Spread
from mrts.studies.study import Parameter, Target

TAKEN = ("variant", "status", "reason", "c2_lower", "c2_upper", "lower_limit", "upper_limit", "duration", "energy")
"""Columns of a study's table beside those of its parameters."""

MOVES = ("sets", "shifts", "scales")
"""What a knob can do to a number: be it, be added to it, multiply it."""


def read_parameters(
    path: Path,
    vary: Mapping[str, Any],
    sample: SampleName,
    given: dict[str, Any],
    filled: dict[str, Any],
    cell: Cell,
) -> tuple[Parameter, ...]:
    """The parameters of a study.

    Args:
        path: The study file, for messages.
        vary: Its key of that name.
        sample: How points are chosen.
        given: Keys and values of the "cell" and the "motion" file; what they leave out on the way to a number that
            varies is written into them.
        filled: The same with all that they leave out.
        cell: The cell.

    Raises:
        InputError: If an entry breaks a rule, leads to no number, or to one that another entry moves.
    """
    if not vary:
        raise InputError(path, "names nothing to vary, such as object.mass: [2, 3, 4].", key="vary")
    reader = _TargetReader(path, filled, cell)
    parameters: dict[str, Parameter] = {}
    for name, value in vary.items():
        key = f"vary.{name}"
        knob = read_knob(path, key, value)
        spread = knob_spread(path, key, knob, sample)
        targets = tuple(reader.targets(name, knob))
        shown = name if _moves(knob) else targets[0].path
        parameters[name] = Parameter(shown, _unit(knob, targets), spread, targets)
        _check_whole(path, key, spread, targets)
    _check_apart(path, parameters)
    for target in (target for parameter in parameters.values() for target in parameter.targets):
        with_place(given, filled, target.keys)
    return tuple(parameters.values())


class _TargetReader:
    """Finds the numbers that entries move.

    Args:
        path: The study file, for messages.
        files: Keys and values of the "cell" and the "motion" file, with all that they leave out.
        cell: The cell.
    """

    def __init__(self, path: Path, files: dict[str, Any], cell: Cell) -> None:
        self.path, self.files, self.cell = path, files, cell
        self.joints = [len(robot.joints) for robot in cell.robots]

    def targets(self, name: str, knob: KnobDescription) -> Iterator[Target]:
        """The numbers that an entry moves."""
        if not _moves(knob):
            yield self._target(f"vary.{name}", self._keys(f"vary.{name}", name))
            return
        self._check_name(name)
        for move in _moves(knob):
            key = f"vary.{name}.{move}"
            for path, factor, offset in self._listed(key, getattr(knob, move)):
                if move == "scales" and (factor, offset) != (1, 0):
                    rule = "a knob that scales takes a list of paths: it is itself the factor of each."
                    raise InputError(self.path, rule, key=key, value=getattr(knob, move))
                if move == "shifts" and offset != 0:
                    raise InputError(self.path, "an offset belongs to 'sets'.", key=key, value=offset)
                yield from self._moved(key, path, move, (factor, offset))

    def _moved(self, key: str, path: str, move: str, line: tuple[float, float]) -> Iterator[Target]:
        """The numbers at one path that a knob moves."""
        found = self._keys(key, path)
        if move == "sets":
            yield self._target(key, found, *line)
            return
        numbers = list(numbers_below(self.files, found))
        if not numbers:
            rule = (
                f"the cell and motion files give no number at {path}, so there is none to move. Write it there first."
            )
            raise InputError(self.path, rule, key=key)
        own = [float(value_at(self.files, number)) for number in numbers]
        if move == "scales" and not any(own):
            rule = f"what is at {path} is 0, and stays 0 however it is scaled. Use 'sets' or 'shifts'."
            raise InputError(self.path, rule, key=key)
        for number, value in zip(numbers, own, strict=True):
            yield self._target(key, number, *((value, 0.0) if move == "scales" else (line[0], value)))

    def _listed(self, key: str, given: object) -> Iterator[tuple[str, float, float]]:
        """Paths with factors and offsets."""
        form = (
            "must be a list of paths, or paths with the factor of each, such as robots.left.base.xyz[0]: -1, or with "
            "{factor: -1, offset: 0.1}"
        )
        if isinstance(given, list) and given and all(isinstance(path, str) for path in given):
            yield from ((path, 1.0, 0.0) for path in given)
            return
        if not isinstance(given, dict) or not given or not all(isinstance(path, str) for path in given):
            raise InputError(self.path, f"{form}.", key=key, value=given)
        for path, line in given.items():
            parts = line if isinstance(line, dict) else {"factor": line}
            numbers = {"factor": 1.0, "offset": 0.0} | parts
            sound = all(is_number(one, -LARGEST_NUMBER, LARGEST_NUMBER) for one in numbers.values())
            if not parts or len(numbers) > 2 or not sound or numbers["factor"] == 0:  # noqa: PLR2004 (the two)
                raise InputError(self.path, f"{form}; a factor is not 0.", key=f"{key}.{path}", value=line)
            yield path, float(numbers["factor"]), float(numbers["offset"])

    def _keys(self, key: str, path: str) -> Keys:
        try:
            return find_keys(self.files, self.joints, path)
        except PathError as error:
            raise InputError(self.path, str(error), key=key, value=path) from None

    def _target(self, key: str, keys: Keys, factor: float = 1.0, offset: float = 0.0) -> Target:
        """One number; a place that holds none, but may, is one."""
        text, value = path_text(self.files, keys), value_at(self.files, keys)
        inside = next(numbers_below(self.files, keys), None)
        if isinstance(value, dict | list):
            advice = "" if inside is None else f": name one of its numbers, such as {path_text(self.files, inside)}"
            raise InputError(self.path, f"{text} is no number{advice}.", key=key)
        if isinstance(value, str | bool):
            raise InputError(self.path, f"{text} is '{value}', which is no number; numbers vary.", key=key)
        unit = number_unit(keys, self.cell.robots, self.cell.wrench_units)
        return Target(text, keys, unit, factor, offset, whole=keys == ("motion", "samples"))

    def _check_name(self, name: str) -> None:
        if not re.fullmatch(IDENTIFIER, name) or len(name) > LONGEST_NAME or name in TAKEN:
            rule = (
                "is the name of a knob that moves several numbers, and heads a column: letters, digits and single "
                f"underscores, at most {LONGEST_NAME}, and none of {', '.join(TAKEN)}."
            )
            raise InputError(self.path, rule, key=f"vary.{name}")


def _moves(knob: KnobDescription) -> list[str]:
    return [move for move in MOVES if getattr(knob, move) != ()]


def _unit(knob: KnobDescription, targets: tuple[Target, ...]) -> str:
    """Unit of a parameter: that of its numbers where they have one unit; a factor has none."""
    units = {target.unit for target in targets}
    return units.pop() if len(units) == 1 and knob.scales == () else ""


def _check_whole(path: Path, key: str, spread: Spread, targets: tuple[Target, ...]) -> None:
    """A whole number takes whole values."""
    for target in targets:
        if target.whole and not (
            isinstance(spread, Levels)
            and all((target.offset + target.factor * level).is_integer() for level in spread.values)
        ):
            raise InputError(path, f"{target.path} is a whole number: list the values that it takes.", key=key)


def _check_apart(path: Path, movers: Mapping[str, Parameter]) -> None:
    """No number is moved twice, nor a part of what another moves."""
    moved: dict[Keys, str] = {}
    above: dict[Keys, str] = {}
    for mover, parameter in movers.items():
        for target in parameter.targets:
            parents = [target.keys[:size] for size in range(1, len(target.keys))]
            other = next(filter(None, map(moved.get, [target.keys, *parents])), above.get(target.keys))
            if other is not None:
                by = f", by '{other}' and '{mover}'" if other != mover else ""
                rule = f"{target.path} is moved twice{by}. Each number has one mover."
                raise InputError(path, rule, key=f"vary.{mover}")
            moved[target.keys] = mover
            above |= dict.fromkeys(parents, mover)

# SPDX-License-Identifier: MIT
"""Records of a file, kinds of values that they share, the pose.

They are checked without any library: pydantic takes a fifth of the time in which a command starts.
"""

import json
import math
import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import cache, partial
from inspect import get_annotations
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, ClassVar, Literal, NoReturn, Self, Union, dataclass_transform, get_args, get_origin

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Mistakes, Remark, as_array, did_you_mean
from mrts.base.input_file import IDENTIFIER, LARGEST_NUMBER, LONGEST_NAME, SMALLEST_NUMBER, check_kind, read_data
from mrts.base.rigid_transform import RigidTransform, rotation_from_rpy, rotations_from_quaternions, snap_rotation

TYPES = {bool: "true or false", int: "a whole number", float: "a number", str: "text"}
MAPPING, LIST, NUMBER = "must be a mapping of keys to values", "must be a list", "must be a number"
FINITE = "must be a finite number"

LIMITS: dict[str, tuple[str, Callable[[Any, Any], bool]]] = {
    "gt": ("must be > {limit:g}", operator.gt),
    "ge": ("must be >= {limit:g}", operator.ge),
    "lt": ("must be < {limit:g}", operator.lt),
    "le": ("must be <= {limit:g}", operator.le),
    "min_length": ("has {length} values, at least {limit} belong here", lambda value, limit: len(value) >= limit),
    "max_length": ("has {length} values, at most {limit} belong here", lambda value, limit: len(value) <= limit),
    "pattern": (
        "must be letters, digits and single underscores, and start with a letter",
        lambda value, limit: re.fullmatch(limit, value) is not None,
    ),
    "smallest": (
        "must be 0, or at least {limit:g} in size",
        lambda value, limit: value == 0 or abs(value) >= limit,
    ),
}
"""The rule and the check of each limit, by pydantic's names."""


class Rule:
    """What numbers, texts and lists must keep.

    Attributes:
        limits: By the names of `LIMITS`; `smallest` is the least size of a number that is not 0.
    """

    def __init__(self, **limits: Any) -> None:
        self.limits = limits

    def check(self, value: Any, given: object) -> None:
        """Check a value of the annotated type."""
        for name, limit in self.limits.items():
            rule, keeps = LIMITS[name]
            if not keeps(value, limit):
                if name == "min_length" and isinstance(value, str):
                    rule = "must have at least {limit} character"
                raise _broken(rule.format(limit=limit, length=len(value) if name.endswith("length") else 0), given)


class Shape:
    """Sizes of an array, or of a tuple, that is an attribute of a dataclass; `check_attributes` checks them.

    Attributes:
        sizes: Such as ("n", 3), those of one letter alike in all attributes.
        finite: Whether its numbers are; else infinity is no limit.
        least: Of each number.
        most: Likewise.
        entries: What they are, for messages.
    """

    def __init__(
        self,
        *sizes: str | int,
        finite: bool = False,
        least: float = -math.inf,
        most: float = math.inf,
        entries: Sequence[str] = (),
    ) -> None:
        self.sizes, self.finite, self.least, self.most, self.entries = sizes, finite, least, most, entries
        self._ends = [f"{side} {end:g}" for side, end in (("at least", least), ("at most", most)) if math.isfinite(end)]
        if least == SMALLEST_NUMBER or most == -SMALLEST_NUMBER:
            self._ends = ["above 0" if least > 0 else "below 0"]

    def check(self, value: Any, letters: dict[str | int, int]) -> None:
        """Check a value beside those before it, and note what its own letters stand for."""
        is_tuple = isinstance(value, tuple)
        given = (len(value),) if is_tuple else value.shape
        if len(given) == len(self.sizes):
            for size, found in zip(self.sizes, given, strict=True):
                letters.setdefault(size, found if isinstance(size, str) else size)
        sizes = tuple(letters.get(size, size) for size in self.sizes)
        sound = is_tuple or bool((np.isfinite(value) if self.finite else ~np.isnan(value)).all())
        if given != sizes or not sound:
            what = "values" if is_tuple else "finite numbers" if self.finite else "numbers (infinity is no limit)"
            shape = f"({sizes[0]},)" if len(sizes) == 1 else f"({', '.join(map(str, sizes))})"
            entries = f": {', '.join(self.entries)}" if self.entries else ""
            raise _broken(f"must be {what} with Shape {shape}{entries}", value if is_tuple else value.tolist())
        if self._ends and (wrong := np.argwhere((value < self.least) | (value > self.most))).size:
            place = wrong[0].tolist()
            raise _broken(f"must be {' and '.join(self._ends)}", float(value[*place])).inside(
                "", "".join(f"[{at}]" for at in place)
            )


def check_attributes(owner: Any, of: type, where: str, **known: int) -> dict[str | int, int]:
    """Check the attributes of a frozen dataclass against their kinds, see `Record`; nobody can write to its arrays.

    Returns:
        What the letters of shapes stand for, those that are known besides.

    Raises:
        InputError: If one is of another kind, or has another shape.
    """
    kinds, _, shapes = _fields_of(of)
    letters: dict[str | int, int] = dict(known.items())
    try:
        values = checked_fields(kinds, {}, {name: getattr(owner, name) for name in kinds})
        for name, shape in shapes.items():
            try:
                shape.check(values[name], letters)
            except InputError as error:
                raise error.inside("", name) from None
    except InputError as error:
        raise error.with_others(()).inside(where) from None
    vars(owner).update(values)
    return letters


class MadeAgain:
    """A dataclass that is made anew where it is unpickled: checked, and with arrays that nobody can write to."""

    def __reduce__(self) -> tuple[Any, ...]:
        own: type = type(self)
        return partial(own, **{name: getattr(self, name) for name in _fields_of(own)[0]}), ()


@cache
def _fields_of(of: Any) -> tuple[dict[str, Any], dict[str, Any], dict[str, Shape]]:
    """Kinds, defaults and shapes of the attributes of a record or a dataclass; found once, many are made."""
    if is_dataclass(of):
        given: list[Field[Any]] = [field for field in fields(of) if field.init]
        kinds = {field.name: field.type for field in given}
        defaults = {field.name: field.default for field in given if field.default is not MISSING}
    else:
        kinds = of.model_fields
        defaults = {name: getattr(of, name) for name in kinds if hasattr(of, name)}
    marks = [(name, mark) for name, kind in kinds.items() for mark in getattr(kind, "__metadata__", ())]
    return kinds, defaults, {name: mark for name, mark in marks if isinstance(mark, Shape)}


@dataclass_transform(frozen_default=True, kw_only_default=True)
class Record:
    """Named values of the annotated kinds; nothing is converted but whole numbers to numbers, and lists to tuples.

    Kinds are float, int, bool, str, Any, Literal, records, dataclasses, arrays, functions, other classes, lists, tuples
    and dictionaries of these, alternatives and None, each annotated with a `Rule`, a function that raises, or nothing.
    Numbers are finite; of arrays, JSON has infinite ones as the texts "inf" and "-inf", and a dataclass checks its own
    arrays. The attribute of a key that is a word of Python ends in an underscore.

    Raises:
        InputError: If a key or a value breaks a rule.
    """

    model_fields: ClassVar[dict[str, Any]] = {}

    def __init_subclass__(cls) -> None:
        bases = (base for base in reversed(cls.__mro__) if issubclass(base, Record) and base is not Record)
        cls.model_fields = {name: kind for base in bases for name, kind in get_annotations(base).items()}

    def __init__(self, **keys: Any) -> None:
        try:
            self._fill(keys)
        except InputError as error:
            raise error.inside(type(self).__name__) from None

    @classmethod
    def model_validate(cls, data: object) -> Self:
        """The record that a mapping describes."""
        if isinstance(data, cls):
            return data
        if not isinstance(data, dict):
            raise _broken(f"{MAPPING}, of {', '.join(cls.model_fields)}", data)
        record = object.__new__(cls)
        record._fill(data)
        return record

    @classmethod
    def read_file(cls, path: Path, what: str) -> Self:
        """The record that a YAML file holds, such as a "cell file".

        Raises:
            InputError: If the file is missing, not YAML, or breaks a rule.
        """
        return cls.read(path, read_data(path, what), what)

    @classmethod
    def read(cls, where: Path | str, data: object, what: str = "") -> Self:
        """The record that a file or a dictionary describes; errors name `where`."""
        try:
            if isinstance(data, dict):
                check_kind(data, what)
            return cls.model_validate(data)
        except InputError as error:
            raise error.inside(where) from None

    def _fill(self, data: dict[Any, Any]) -> None:
        own: Any = type(self)
        kinds, defaults, _ = _fields_of(own)
        vars(self).update(checked_fields(kinds, defaults, data))
        if problem := self.problem():
            raise InputError("", f"{problem.rstrip('.')}.")

    def problem(self) -> str:
        """The rule that values break with each other; empty if none."""
        return ""

    def model_copy(self, *, update: dict[str, Any]) -> Self:
        """The same with other values, which are not checked."""
        record = object.__new__(type(self))
        vars(record).update(vars(self) | update)
        return record

    def model_dump(self) -> dict[str, Any]:
        """Dictionaries, lists and values."""
        return {name: dumped(value) for name, value in self}

    def __setattr__(self, name: str, _value: object) -> None:
        raise AttributeError(f"{type(self).__name__}.{name} cannot be changed")

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and vars(self) == vars(other)

    __hash__ = None  # type: ignore[assignment]  # it holds lists

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        return iter([(name, getattr(self, name)) for name in self.model_fields])

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self)})"


def read_json(text: str) -> Any:
    """The value of a JSON text."""
    try:
        return json.loads(text, parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        raise InputError("", f"is not JSON: {error}.") from None


def _refuse(constant: str) -> NoReturn:
    raise _broken(FINITE, constant)


def checked_fields(kinds: dict[str, Any], defaults: dict[str, Any], data: dict[Any, Any]) -> dict[str, Any]:
    """The values of a mapping by name, each of its kind; defaults where the mapping leaves one out."""
    mistakes, values = Mistakes(), {}
    keys = {name.rstrip("_"): name for name in kinds}
    for key in data:
        if key not in keys:
            rule = f"unknown key '{key}'{did_you_mean(str(key), keys)} The keys here are: {', '.join(keys)}."
            mistakes.add(InputError("", rule))
    for key, name in keys.items():
        try:
            if key not in data and name not in defaults:
                raise InputError("", "this key is required.", key=key)  # noqa: TRY301 (noted with the others)
            values[name] = _at(key, kinds[name], data[key] if key in data else defaults[name])
        except InputError as error:
            mistakes.add(error)
    mistakes.raise_noted()
    return values


def _at(key: str, kind: Any, value: object) -> Any:
    try:
        return checked(kind, value)
    except InputError as error:
        raise error.inside("", key) from None


def _each_at(entries: Iterable[tuple[str, Any, object]]) -> list[Any]:
    read, mistakes = [], Mistakes()
    for key, kind, value in entries:
        try:
            read.append(_at(key, kind, value))
        except InputError as error:
            mistakes.add(error)
    mistakes.raise_noted()
    return read


def checked(kind: Any, value: Any) -> Any:
    """A value of a kind, see `Record`."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated:
        read = checked(parts[0], value)
        for rule in parts[1:]:
            if isinstance(rule, Rule):
                rule.check(read, value)
            elif callable(rule):
                rule(read)
        return read
    if origin in {Union, UnionType}:
        return None if value is None and NoneType in parts else _one_of(value, *(p for p in parts if p is not NoneType))
    if origin is not None:
        return _of_parts(origin, parts, value)
    if kind is Any:
        return value
    if is_dataclass(kind):
        return value if type(value) is kind else _dataclass(kind, value)
    return kind.model_validate(value) if issubclass(kind, Record) else _plain(kind, value)


def _one_of(value: Any, *kinds: Any) -> Any:
    """A value of the first of some kinds that takes it; if none does, the error of the one that went deepest."""
    errors = []
    for kind in kinds:
        try:
            return checked(kind, value)
        except InputError as error:
            errors.append(error)
    forms = (LIST, MAPPING, NUMBER)
    raise max(errors, key=lambda error: (len(re.findall(r"[^.[]+", error.key)), not error.rule.startswith(forms)))


def _dataclass(kind: Any, value: Any) -> Any:
    """A value of a dataclass from a mapping; what its own check refuses is told as a rule of the mapping."""
    if not isinstance(value, dict):
        raise _broken(f"must be of type {kind.__name__}", value)
    kinds, defaults, _ = _fields_of(kind)
    return kind(**checked_fields(kinds, defaults, value))


def _of_parts(origin: Any, parts: tuple[Any, ...], value: Any) -> Any:
    if origin is np.ndarray:
        array = as_array("", value)
        array.setflags(write=False)
        return array
    if origin is Callable:
        if not callable(value):
            raise _broken("must be a function", value)
        return value
    if origin is Literal:
        if not isinstance(value, str) or value not in parts:
            *others, last = map(repr, parts)
            raise _broken(f"must be {', '.join(others)} or {last}" if others else f"must be {last}", value)
        return value
    if origin in {dict, Mapping}:
        if not isinstance(value, dict):
            raise _broken(MAPPING, value)
        names = _each_at((str(name), parts[0], name) for name in value)
        return dict(zip(names, _each_at((str(name), parts[1], entry) for name, entry in value.items()), strict=True))
    if not isinstance(value, list | tuple):
        raise _broken(LIST, value)
    return _items(origin, parts, value)


def _items(origin: Any, kinds: tuple[Any, ...], value: list[Any] | tuple[Any, ...]) -> Any:
    if origin is not tuple or kinds[-1] is Ellipsis:
        read = _each_at((f"[{index}]", kinds[0], item) for index, item in enumerate(value))
        return tuple(read) if origin is tuple else read
    Rule(min_length=len(kinds), max_length=len(kinds)).check(value, value)
    return tuple(_each_at((f"[{index}]", *pair) for index, pair in enumerate(zip(kinds, value, strict=True))))


def _plain(kind: type, value: Any) -> Any:
    taken: Any = (float, int) if kind is float else kind
    if not isinstance(value, taken) or (isinstance(value, bool) and kind is not bool):
        raise _broken(f"must be {TYPES.get(kind, f'of type {kind.__name__}')}", value)
    if kind is not float:
        return value
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise _broken(FINITE, value)
    return number


def _broken(rule: str, value: object) -> InputError:
    return InputError("", f"{rule} (it is empty)." if value is None else f"{rule}.", value=value)


def dumped(value: Any) -> Any:
    """A value as JSON values; an infinite number is "inf" or "-inf"."""
    if isinstance(value, Record):
        return value.model_dump()
    if is_dataclass(value):
        return {field.name: dumped(getattr(value, field.name)) for field in fields(value) if field.init}
    if isinstance(value, list | tuple):
        return [dumped(item) for item in value]
    if isinstance(value, Mapping):
        return {name: dumped(item) for name, item in value.items()}
    if hasattr(value, "tolist"):
        return dumped(value.tolist())
    return str(value) if isinstance(value, float) and math.isinf(value) else value


Name = Annotated[str, Rule(pattern=IDENTIFIER, max_length=LONGEST_NAME)]
"""Of a cell or a robot: it stands in C text and in paths."""

Coordinate = Annotated[float, Rule(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER)]
Finite = Annotated[float, Rule(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER, smallest=SMALLEST_NUMBER)]
Positive = Annotated[float, Rule(gt=0, le=LARGEST_NUMBER, smallest=SMALLEST_NUMBER)]
Angle = Annotated[float, Rule(ge=-1e4, le=1e4)]
Angles3 = Annotated[list[Angle], Rule(min_length=3, max_length=3)]
Vector3 = Annotated[list[Coordinate], Rule(min_length=3, max_length=3)]


Quaternion = Annotated[list[Coordinate], Rule(min_length=4, max_length=4)]

ROTATIONS = ("rpy", "quaternion_wxyz", "quaternion_xyzw")
"""Keys that give a rotation; a pose has one of them."""

FEW_DIGITS = 1e-3
"""Largest difference of a unit quaternion's length from 1: printed with few digits."""

WHOLE_TURN = 2 * math.pi
"""An angle beyond it [rad] is rather meant in degrees."""


class Pose(Record):
    """A frame: position and rotation, which is none where none is given.

    Attributes:
        xyz: Position, Shape (3,) [m].
        rpy: Rotation R = Rz(yaw) Ry(pitch) Rx(roll), URDF's roll, pitch, yaw, Shape (3,) [rad].
        quaternion_wxyz: Rotation as a unit quaternion, its real part first, Shape (4,).
        quaternion_xyzw: The same with its real part last, as in ROS.
    """

    xyz: Vector3 = [0.0, 0.0, 0.0]  # noqa: RUF012 (each record has its own copy)
    rpy: Angles3 | None = None
    quaternion_wxyz: Quaternion | None = None
    quaternion_xyzw: Quaternion | None = None

    @property
    def transform(self) -> RigidTransform:
        """The frame."""
        return RigidTransform(self.rotation(), np.array(self.xyz, dtype=np.float64))

    def rotation(self) -> Array:
        """Of the frame, Shape (3, 3)."""
        if self.rpy is not None:
            return rotation_from_rpy(*self.rpy)
        x_to_w = self._x_to_w()
        return np.eye(3) if x_to_w is None else snap_rotation(rotations_from_quaternions(np.array(x_to_w)))

    def degrees_remarks(self, where: str) -> tuple[Remark, ...]:
        """That its angles seem to be in degrees, if one is beyond a whole turn."""
        if self.rpy is None or all(abs(angle) <= WHOLE_TURN for angle in self.rpy):
            return ()
        given, meant = (
            ", ".join(f"{angle:.6g}" for angle in angles) for angles in (self.rpy, map(math.radians, self.rpy))
        )
        text = f"{where}.rpy is [{given}] rad: if degrees are meant, it is [{meant}]."
        return (Remark.hint("rpy-degrees", text),)

    def problem(self) -> str:
        """The rule that its keys break with each other; empty if none."""
        given = [key for key in ROTATIONS if getattr(self, key) is not None]
        if len(given) > 1:
            return f"a rotation is given once, here by {' and '.join(given)}"
        quaternion = self._x_to_w()
        length = 1.0 if quaternion is None else math.hypot(*quaternion)
        if abs(length - 1) > FEW_DIGITS:
            return f"a quaternion of a rotation has the length 1; the length of {given[0]} is {length:.6g}"
        return ""

    def model_dump(self) -> dict[str, Any]:
        """Keys that it has, and angles of 0 where no rotation is given."""
        known = {key: value for key, value in super().model_dump().items() if value is not None}
        return known if len(known) > 1 else known | {"rpy": [0.0, 0.0, 0.0]}

    def _x_to_w(self) -> list[float] | None:
        if self.quaternion_wxyz is not None:
            return [*self.quaternion_wxyz[1:], self.quaternion_wxyz[0]]
        return self.quaternion_xyzw

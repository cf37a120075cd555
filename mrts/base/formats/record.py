# SPDX-License-Identifier: MIT
"""Records of a file, checked without any library: pydantic takes a fifth of the time in which a command starts."""

import json
import math
import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from inspect import get_annotations
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, ClassVar, Literal, NoReturn, Self, Union, dataclass_transform, get_args, get_origin

from mrts.base.errors import InputError, Mistakes, as_array

RULES = {
    "bool_parsing": "must be true or false",
    "bool_type": "must be true or false",
    "dict_type": "must be a mapping of keys to values",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "greater_than": "must be > {gt:g}",
    "greater_than_equal": "must be >= {ge:g}",
    "int_type": "must be a whole number",
    "less_than": "must be < {lt:g}",
    "less_than_equal": "must be <= {le:g}",
    "list_type": "must be a list",
    "literal_error": "must be {expected}",
    "missing": "this key is required",
    "model_type": "must be a mapping of keys to values",
    "string_pattern_mismatch": "must be letters, digits and single underscores, and start with a letter",
    "string_too_short": "must have at least {min_length} character",
    "string_type": "must be text",
    "too_long": "has {actual_length} values, at most {max_length} belong here",
    "too_near_zero": "must be 0, or at least {smallest:g} in size",
    "too_short": "has {actual_length} values, at least {min_length} belong here",
}
"""What is wrong with a value, by pydantic's names; fields are numbers and texts of the format, nothing of the file."""


class Rule:
    """What numbers, texts and lists must keep.

    Attributes:
        limits: By pydantic's names: gt, ge, lt, le, min_length, max_length, pattern, allow_inf_nan; and `smallest`, the
            least size of a number that is not 0.
    """

    def __init__(self, **limits: Any) -> None:
        self.limits = limits

    def check(self, value: Any, given: object) -> None:
        """Check a value of the annotated type."""
        for name, limit in self.limits.items():
            kind, keeps = _LIMITS[name]
            if not keeps(value, limit):
                length = len(value) if name.endswith("length") else 0
                kind = "string_too_short" if kind == "too_short" and isinstance(value, str) else kind
                _fail(kind, given, **{name: limit, "actual_length": length})


_LIMITS: dict[str, tuple[str, Callable[[Any, Any], bool]]] = {
    "gt": ("greater_than", operator.gt),
    "ge": ("greater_than_equal", operator.ge),
    "lt": ("less_than", operator.lt),
    "le": ("less_than_equal", operator.le),
    "min_length": ("too_short", lambda value, limit: len(value) >= limit),
    "max_length": ("too_long", lambda value, limit: len(value) <= limit),
    "pattern": ("string_pattern_mismatch", lambda value, limit: re.fullmatch(limit, value) is not None),
    "allow_inf_nan": ("finite_number", lambda value, limit: limit or math.isfinite(value)),
    "smallest": ("too_near_zero", lambda value, limit: value == 0 or abs(value) >= limit),
}


@dataclass_transform(frozen_default=True, kw_only_default=True)
class Record:
    """Named values of the annotated kinds; nothing is converted but whole numbers to numbers, and lists to tuples.

    Kinds are float, int, bool, str, Any, Literal, records, dataclasses, arrays, lists, tuples and dictionaries of
    these, alternatives and None, each with a `Rule` or not. Numbers are finite; of arrays, JSON has infinite ones as
    the texts "inf" and "-inf", and a dataclass checks its own arrays. The attribute of a key that is a word of Python
    ends in an underscore.

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
            raise _broken(f"{RULES['model_type']}, of {', '.join(cls.model_fields)}", data)
        record = object.__new__(cls)
        record._fill(data)
        return record

    @classmethod
    def read(cls, where: Path | str, data: dict[Any, Any]) -> Self:
        """The record that a mapping of a file describes."""
        try:
            return cls.model_validate(data)
        except InputError as error:
            raise error.inside(where) from None

    def _fill(self, data: dict[Any, Any]) -> None:
        vars(self).update(_checked_fields(self.model_fields, _defaults(type(self)), data))
        if problem := self.problem():
            raise InputError("", f"{problem.rstrip('.')}.")

    @classmethod
    def model_validate_json(cls, text: str) -> Self:
        """The record that a JSON text describes."""
        return cls.model_validate(read_json(text))

    def problem(self) -> str:
        """The rule that values break with each other; empty if none."""
        return ""

    def model_copy(self, *, update: dict[str, Any]) -> Self:
        """The same with other values, which are not checked."""
        record = object.__new__(type(self))
        vars(record).update(vars(self) | update)
        return record

    def model_dump(self, *, include: set[str] | None = None, exclude: set[str] | None = None) -> dict[str, Any]:
        """Dictionaries, lists and values."""
        names = (name for name in self.model_fields if include is None or name in include)
        return {name: dumped(getattr(self, name)) for name in names if name not in (exclude or ())}

    def __setattr__(self, name: str, _value: object) -> None:
        raise AttributeError(f"{type(self).__name__}.{name} cannot be changed")

    def __delattr__(self, name: str) -> None:
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
    _fail("finite_number", constant)


def _defaults(cls: type[Record]) -> dict[str, Any]:
    return {name: getattr(cls, name) for name in cls.model_fields if hasattr(cls, name)}


def _checked_fields(kinds: dict[str, Any], defaults: dict[str, Any], data: dict[Any, Any]) -> dict[str, Any]:
    mistakes, values = Mistakes(), {}
    keys = {name.rstrip("_"): name for name in kinds}
    for key in data:
        if key not in keys:
            mistakes.add(_unknown_key(key, list(keys)))
    for key, name in keys.items():
        try:
            if key not in data and name not in defaults:
                raise InputError("", f"{RULES['missing']}.", key=key)  # noqa: TRY301 (noted with the others)
            values[name] = _at(key, kinds[name], data[key] if key in data else defaults[name])
        except InputError as error:
            mistakes.add(error)
    mistakes.raise_noted()
    return values


def _unknown_key(key: object, known: list[str]) -> InputError:
    import difflib  # noqa: PLC0415 (for this message only)

    close = difflib.get_close_matches(str(key), known, n=1)
    hint = f"; did you mean '{close[0]}'?" if close else ""
    rule = f"unknown key '{key}'{hint or '.'} The keys here are: {', '.join(known)}."
    return InputError("", rule)


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
            rule.check(read, value)
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
    forms = tuple(RULES[kind] for kind in ("list_type", "model_type", "float_type"))
    raise max(errors, key=lambda error: (len(re.findall(r"[^.[]+", error.key)), not error.rule.startswith(forms)))


def _dataclass(kind: Any, value: Any) -> Any:
    """A value of a dataclass from a mapping; what its own check refuses is told as a rule of the mapping."""
    if not isinstance(value, dict):
        _fail("model_type", value)
    given: list[Field[Any]] = [field for field in fields(kind) if field.init]
    defaults = {field.name: field.default for field in given if field.default is not MISSING}
    values = _checked_fields({field.name: field.type for field in given}, defaults, value)
    return kind(**values)


def _of_parts(origin: Any, parts: tuple[Any, ...], value: Any) -> Any:
    if origin is Literal:
        if not isinstance(value, str) or value not in parts:
            *others, last = map(repr, parts)
            _fail("literal_error", value, expected=f"{', '.join(others)} or {last}" if others else last)
        return value
    if origin in {dict, Mapping}:
        if not isinstance(value, dict):
            _fail("dict_type", value)
        names = _each_at((str(name), parts[0], name) for name in value)
        return dict(zip(names, _each_at((str(name), parts[1], entry) for name, entry in value.items()), strict=True))
    if getattr(origin, "__name__", "") == "ndarray":
        return as_array("", value)
    if not isinstance(value, list | tuple):
        _fail("list_type", value)
    return _items(origin, parts, value)


def _items(origin: Any, kinds: tuple[Any, ...], value: list[Any] | tuple[Any, ...]) -> Any:
    if origin is list or kinds[-1] is Ellipsis:
        return origin(_each_at((f"[{index}]", kinds[0], item) for index, item in enumerate(value)))
    if len(value) != len(kinds):
        kind, length = ("too_long", "max_length") if len(value) > len(kinds) else ("too_short", "min_length")
        _fail(kind, value, actual_length=len(value), **{length: len(kinds)})
    return tuple(_each_at((f"[{index}]", *pair) for index, pair in enumerate(zip(kinds, value, strict=True))))


def _plain(kind: type, value: Any) -> Any:
    if kind is float:
        if isinstance(value, bool) or not isinstance(value, float | int):
            _fail("float_type", value)
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            _fail("finite_number", value)
        return number
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        _fail({int: "int_type", bool: "bool_type", str: "string_type"}[kind], value)
    return value


def _fail(kind: str, value: object, **of_format: Any) -> NoReturn:
    raise _broken(RULES[kind].format(**of_format), value)


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

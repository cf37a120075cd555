# SPDX-License-Identifier: MIT
"""Values of dataclasses as a tree for JSON with arrays beside it, and back.

A field is written under its own name and read by its annotation, so only classes that a root class names are ever made.
What stands in several places is written once, and is one object again when it is read.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

Arrays = dict[str, NDArray[Any]]

SMALL = 16
"""Numbers of an array that stands in the tree; larger ones stand under their path."""

LEFT_OUT = {"course", "problem"}
"""Fields that are functions: None when they are read."""

FOUND_FIELDS = {"RangeEnd.named": "rows", "Excess.named": "row"}
FOUND_FIELDS |= {"ScalingResult.found": "range", "ScalingResult.remarks": "warnings"}
"""Fields that may hold what finds a value: the attribute that has the value is written instead."""


class TreeWriter:
    """Writes values.

    Args:
        own: How values of some classes are written, each a function of the writer, a value and its path.
        found: Cached properties that are kept, by class: finding them takes what is not written.

    Attributes:
        arrays: What stands beside the tree.
    """

    def __init__(self, own: Mapping[type, Callable[..., Any]], found: Mapping[str, Sequence[str]]) -> None:
        self.arrays: Arrays = {}
        self._own, self._found = own, found
        self._known: dict[int, tuple[object, str]] = {}

    def entry(self, value: Any, path: str) -> Any:  # noqa: PLR0911 (one a kind of value)
        """What JSON says of a value; large arrays are added to `arrays`."""
        if isinstance(value, np.generic | Enum):
            return value.item() if isinstance(value, np.generic) else value.value
        if value is None or isinstance(value, bool | int | float | str):
            return value
        if isinstance(value, Mapping):
            return {name: self.entry(part, f"{path}.{name}") for name, part in value.items()}
        if isinstance(value, Sequence):
            return [self.entry(part, f"{path}.{place}") for place, part in enumerate(value)]
        _, first = self._known.setdefault(id(value), (value, path))  # kept, so that no other has its id
        if first != path:
            return {"same": first}
        if isinstance(value, np.ndarray):
            if value.size > SMALL:
                self.arrays[path] = value
                return {"array": path}
            return {"numbers": value.ravel().tolist(), "kind": value.dtype.str, "shape": value.shape}
        kind = type(value)
        if kind in self._own:
            return self._own[kind](self, value, path)
        names = {field.name: field.name for field in fields(value) if field.name not in LEFT_OUT}
        names |= {name: FOUND_FIELDS.get(f"{kind.__name__}.{name}", name) for name in names}
        names |= {name: name for name in self._found.get(kind.__name__, ())}
        parts = {name: self.entry(getattr(value, read), _below(path, name)) for name, read in names.items()}
        return {"class": kind.__name__, **parts}


class TreeReader:
    """Reads what a `TreeWriter` wrote.

    Args:
        arrays: That stood beside the tree.
        own: How values of some classes are read, each a function of the reader, an entry and its path.
        names: Classes that annotations name but their files import for types alone.
    """

    def __init__(self, arrays: Arrays, own: Mapping[type, Callable[..., Any]], names: Mapping[str, Any]) -> None:
        self._arrays, self._own, self._names = arrays, own, dict(names)
        self._known: dict[str, Any] = {}
        self._kinds = cache(self._kinds_of)

    def value(self, kind: Any, entry: Any, path: str) -> Any:
        """The value of an entry."""
        options = get_args(kind) if get_origin(kind) in {Union, UnionType} else (kind,)
        for option in options:
            if _fits(option, entry):
                return self._value(option, entry, path)
        raise TypeError(f"{path} is not of {kind}")

    def _value(self, kind: Any, entry: Any, path: str) -> Any:
        origin, inner = get_origin(kind), get_args(kind)
        if isinstance(entry, list):
            kinds = inner if origin is tuple and inner[-1] is not Ellipsis else inner[:1] * len(entry)
            parts = (self.value(of, part, f"{path}.{place}")
                     for place, (of, part) in enumerate(zip(kinds, entry, strict=True)))  # fmt: skip
            return list(parts) if origin is list else tuple(parts)
        if not isinstance(entry, dict):
            return kind(entry) if isinstance(kind, type) and issubclass(kind, Enum) else entry
        if origin is not None and issubclass(origin, Mapping):
            return {name: self.value(inner[1], part, f"{path}.{name}") for name, part in entry.items()}
        if "same" in entry:
            return self._known[entry["same"]]
        if origin is np.ndarray:
            self._known[path] = array = self._array(entry)
            return array
        found = _family(kind)[entry["class"]]
        value = self._own[found](self, entry, path) if found in self._own else self.made(found, entry, path)
        self._known[path] = value
        return value

    def _array(self, entry: dict[str, Any]) -> NDArray[Any]:
        found = self._arrays[entry["array"]] if "array" in entry else None
        kind = np.dtype(entry["kind"]) if found is None else found.dtype
        if kind.kind not in "biuf":
            raise TypeError(f"{kind} are no numbers")
        return np.array(entry["numbers"], kind).reshape(entry["shape"]) if found is None else found

    def made(self, kind: type, entry: dict[str, Any], path: str) -> Any:
        """A value of a class, made as an unpickled one is."""
        kinds = self._kinds(kind)
        state: dict[str, Any] = {field.name: None for field in fields(kind) if field.name in LEFT_OUT}
        state |= {
            name: self.value(kinds[name], part, _below(path, name)) for name, part in entry.items() if name != "class"
        }
        if missing := {field.name for field in fields(kind)} - state.keys():
            raise TypeError(f"{path} lacks {', '.join(sorted(missing))}")
        value: Any = object.__new__(kind)
        getattr(value, "__setstate__", vars(value).update)(state)
        return value

    def _kinds_of(self, kind: type) -> dict[str, Any]:
        kinds = get_type_hints(kind, localns=self._names)
        for name in dir(kind):
            find = getattr(getattr(kind, name), "func", None)
            if find is not None:
                kinds[name] = get_type_hints(find, localns=self._names)["return"]
        return kinds


def _below(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name


def _family(kind: Any) -> dict[str, Any]:
    return {kind.__name__: kind} | {name: one for sub in kind.__subclasses__() for name, one in _family(sub).items()}


def _fits(kind: Any, entry: Any) -> bool:  # noqa: PLR0911 (one a kind of entry)
    """Whether an entry may be one of a kind that is no union."""
    origin = get_origin(kind)
    if origin is Literal:
        return entry in get_args(kind)
    if isinstance(entry, list):
        return origin in {list, tuple, Sequence}
    if isinstance(entry, dict):
        if {"array", "numbers"} & entry.keys():
            return origin is np.ndarray
        if "class" in entry:
            return is_dataclass(kind) and entry["class"] in _family(kind)
        return "same" in entry or origin in {dict, Mapping}
    if isinstance(kind, type) and issubclass(kind, Enum):
        return entry in {member.value for member in kind}
    if kind is float:
        return isinstance(entry, int | float) and not isinstance(entry, bool)
    return kind is type(entry)  # NoneType too

# SPDX-License-Identifier: MIT
"""What the arguments of public functions must be: a wrong one is named where it enters, not where it first hurts."""

from collections.abc import Callable
from importlib.util import find_spec
from math import inf, isfinite
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import Any

from mrts.base.errors import InputError

Progress = Callable[[int, int], None]
"""Told how many of how many pieces of work are done."""

WORDS = {
    "Mapping": "a dictionary",
    "NoneType": "None",
    "PathLike": "a Path",
    "bool": "True or False",
    "float": "a number",
    "int": "a whole number",
    "str": "text",
}


def check_type(name: str, value: object, *kinds: type) -> None:
    """Check what an argument is."""
    if isinstance(value, kinds) and (bool in kinds or not isinstance(value, bool)):
        return
    *others, last = map(_type_name, kinds)
    allowed = f"{', '.join(others)} or {last}" if others else last
    given = "None" if value is None else f"of type {type(value).__name__}"
    inside = " Give its `retimed`." if isinstance(getattr(value, "retimed", object()), kinds) else ""
    raise InputError(name, f"must be {allowed}; it is {given}.{inside}", value=value)


def _type_name(kind: type) -> str:
    return WORDS.get(kind.__name__, f"of type {kind.__name__}")


def is_number(value: object, low: float = -inf, high: float = inf) -> bool:
    """Whether an argument is a finite number within bounds."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    try:
        number = float(value)
    except OverflowError:  # a whole number may be larger than any other
        return False
    return isfinite(number) and low <= number <= high


def check_callable(name: str, value: object) -> None:
    """Check that an argument can be called."""
    if not callable(value):
        raise InputError(name, f"must be a function; it is of type {type(value).__name__}.", value=value)


def require_extra(where: Path | str, extra: str, *packages: str, value: object = None) -> None:
    """Check that the packages are installed that an extra brings, before any work."""
    for package in packages:
        if find_spec(package) is None:
            raise InputError(where, f"needs {package}: pip install 'mrts[{extra}]'.", value=value)


def as_path(name: str, value: Any) -> Path:
    """An argument as a path."""
    check_type(name, value, str, PathLike)
    if value == "":
        raise InputError(name, "must not be empty: name a file or a folder.", value=value)
    try:
        return Path(value)
    except TypeError:  # a PathLike of bytes
        raise InputError(name, "must be a path, as text or a Path.", value=value) from None

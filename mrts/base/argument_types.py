# SPDX-License-Identifier: MIT
"""What the arguments of public functions must be: a wrong one is named where it enters, not where it first hurts."""

from collections.abc import Callable
from math import inf, isfinite
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import Any

from mrts.base.errors import InputError

Progress = Callable[[int, int], None]
"""Told how many of how many pieces of work are done."""

WORDS = {
    "Cell": "a cell, as from mrts.load_cell",
    "ClosureBound": "a ClosureBound, such as mrts.ClosureBound(2e-3, 5e-3)",
    "CellFunctions": "the functions of a cell from mrts.load_cell",
    "Contact": "a contact, as from mrts.pad_contact",
    "CoordinatedMotion": "motion of the whole cell, as from mrts.follow_object",
    "JointTable": "a table of joint motion, as from mrts.load_motion",
    "LoadBox": "a mrts.LoadBox",
    "LoadSharing": "a LoadSharing (LoadSharing() is the equal one)",
    "Mapping": "a dictionary",
    "MotionDescription": "a mrts.MotionDescription",
    "NoneType": "None",
    "ObjectMotion": "motion of the object, as from mrts.load_motion",
    "PathLike": "a Path",
    "Remark": "a remark, as of a cell",
    "RetimingResult": "one of mrts.retime",
    "Robot": "a robot, as from mrts.load_cell",
    "RobotSource": "that of a robot from mrts.load_cell",
    "ScalingResult": "a result of mrts.scale",
    "Study": "a study, as from mrts.read_study",
    "bool": "True or False",
    "float": "a number",
    "int": "a whole number",
    "integer": "one of numpy",
    "str": "text",
}
"""What a type is called in a message."""


def check_type(name: str, value: object, *kinds: type) -> None:
    """Check what an argument is.

    Args:
        name: Of the argument.
        value: What was given.
        *kinds: Types that it may have; a truth value counts as no number.

    Raises:
        InputError: If it is something else.
    """
    if isinstance(value, kinds) and (bool in kinds or not isinstance(value, bool)):
        return
    *others, last = (WORDS.get(kind.__name__, kind.__name__) for kind in kinds)
    allowed = f"{', '.join(others)} or {last}" if others else last
    given = "None" if value is None else f"of type {type(value).__name__}"
    inside = " Give its `retimed`." if isinstance(getattr(value, "retimed", None), kinds) else ""
    raise InputError(name, f"must be {allowed}; it is {given}.{inside}", value=value)


def is_number(value: object, low: float = -inf, high: float = inf) -> bool:
    """Whether an argument is a finite number within bounds."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    try:
        number = float(value)
    except OverflowError:  # a whole number may be larger than any other
        return False
    return isfinite(number) and low <= number <= high


def check_list(name: str, value: object, kind: type) -> None:
    """Check that an argument is a list or tuple of values of one type."""
    if not isinstance(value, list | tuple) or not all(isinstance(each, kind) for each in value):
        raise InputError(name, f"must be a tuple, each of it {WORDS[kind.__name__]}.", value=value)


def check_callable(name: str, value: object) -> None:
    """Check that an argument can be called."""
    if not callable(value):
        raise InputError(name, f"must be a function; it is of type {type(value).__name__}.", value=value)


def as_path(name: str, value: Any) -> Path:
    """An argument as a path."""
    check_type(name, value, str, PathLike)
    if value == "":
        raise InputError(name, "must not be empty: name a file or a folder.", value=value)
    try:
        return Path(value)
    except TypeError:  # a PathLike of bytes
        raise InputError(name, "must be a path, as text or a Path.", value=value) from None

# SPDX-License-Identifier: MIT
"""Strict reading of YAML input files: every mistake becomes one `InputError` with file, key, value and rule."""

import difflib
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidatorFunctionWrapHandler, model_validator
from pydantic_core import ErrorDetails, PydanticCustomError

from mrts.base.errors import InputError
from mrts.base.regular_file import read_regular
from mrts.base.yaml_parser import MAX_YAML_BYTES, MAX_YAML_DEPTH, parse_yaml

MAX_FILE_BYTES = 30_000_000
"""Far above any cell, motion, URDF or generated C file: a larger one is a mistake."""

MAX_URDF_BYTES = 3_000_000
"""Some thousand links."""

LARGEST_NUMBER = 1e12
"""Largest magnitude of a number in an input file, in SI units: anything larger is a mistake and would overflow."""

IDENTIFIER = r"^[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*$"
"""Letters, digits and single underscores: what C, file names and CasADi all accept."""

LONGEST_NAME = 40
Name = Annotated[str, Field(pattern=IDENTIFIER, max_length=LONGEST_NAME)]
"""Of a cell or a robot: it stands in C text and in paths."""

Finite = Annotated[float, Field(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, le=LARGEST_NUMBER, allow_inf_nan=False)]
Angle = Annotated[float, Field(ge=-1e4, le=1e4, allow_inf_nan=False)]
Angles3 = Annotated[list[Angle], Field(min_length=3, max_length=3)]
Vector3 = Annotated[list[Finite], Field(min_length=3, max_length=3)]


class StrictModel(BaseModel):
    """Base of the file formats: unknown keys are refused with the known ones, types are not coerced."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    @model_validator(mode="wrap")
    @classmethod
    def _name_unknown_keys(cls, data: Any, handler: ValidatorFunctionWrapHandler) -> Self:
        if isinstance(data, dict):
            fields = [field.alias or name for name, field in cls.model_fields.items()]
            for key in data:
                if key not in fields:
                    close = difflib.get_close_matches(str(key), fields, n=1)
                    hint = f"; did you mean '{close[0]}'?" if close else ""
                    known = ", ".join(fields)
                    raise broken_rule(f"unknown key '{key}'{hint or '.'} The keys here are: {known}")
        model: Self = handler(data)
        return model


class Pose(StrictModel):
    """A frame: position and URDF roll, pitch, yaw.

    Attributes:
        xyz: Position, Shape (3,) [m].
        rpy: Rotation R = Rz(yaw) Ry(pitch) Rx(roll), Shape (3,) [rad].
    """

    xyz: Vector3 = [0.0, 0.0, 0.0]
    rpy: Angles3 = [0.0, 0.0, 0.0]


Model = TypeVar("Model", bound=StrictModel)


def read_text(path: Path, what: str, most: int = MAX_FILE_BYTES) -> str:
    """Text of an input file, with Unix line ends.

    Args:
        path: The file.
        what: What the file is, for the message: "cell file".
        most: Bytes that it may have.

    Raises:
        InputError: If it is missing, no regular file, unreadable, too large, or not UTF-8.
    """
    try:
        text = read_regular(path, what, most).decode()
    except UnicodeDecodeError:
        raise InputError(path, f"this {what} is not UTF-8 text.") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_model(path: Path, model: type[Model], what: str) -> Model:
    """Read and validate a YAML file.

    Args:
        path: The file.
        model: The format that it must have.
        what: What the file is, for messages: "cell file".

    Raises:
        InputError: If the file is missing, not YAML, or breaks a rule of the format.
    """
    text = read_text(path, what, MAX_YAML_BYTES)
    try:
        data = parse_yaml(text)
    except ValueError as error:
        raise InputError(path, f"this {what} {error}.") from None
    return validated(path, data, model, what)


def validated(where: Path | str, data: object, model: type[Model], what: str) -> Model:
    """What a file or a dictionary says, validated.

    Args:
        where: The file, or what the dictionary is, for messages.
        data: Mappings, lists, texts and numbers.
        model: The format that it must have.
        what: What it is, for messages: "cell file".

    Raises:
        InputError: If it breaks a rule of the format.
    """
    if not isinstance(data, dict):
        raise InputError(
            where, f"a {what} is a mapping of keys to values ({', '.join(model.model_fields)}).", value=data
        )
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise broken_format(where, error) from None
    except InputError as error:  # of a format that can also be built in Python
        raise InputError(where, error.rule, key=error.key, value=error.value) from None


def plain(where: str, data: object, depth: int = MAX_YAML_DEPTH) -> object:
    """A value as a YAML file could hold it: numpy's arrays and numbers, tuples and paths become lists, numbers, text.

    Args:
        where: What the value is, for messages.
        data: A dictionary made in Python.
        depth: How deep lists and dictionaries may lie in each other.

    Raises:
        InputError: If they lie deeper, as where one holds itself.
    """
    if depth < 0:
        raise InputError(where, f"its lists and keys may lie {MAX_YAML_DEPTH} deep at most.")
    if isinstance(data, Mapping):
        return {key: plain(where, value, depth - 1) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [plain(where, value, depth - 1) for value in data]
    if isinstance(data, np.ndarray):
        return plain(where, data.tolist(), depth - 1)
    if isinstance(data, np.generic):
        return data.item()
    return str(data) if isinstance(data, Path) else data


def broken_rule(rule: str) -> PydanticCustomError:
    """An error for a validator to raise: a rule that its sentence explains by itself, without the value.

    Args:
        rule: May quote what a user wrote: it is the value of a field, and never read as a template.
    """
    return PydanticCustomError("rule", "{rule}", {"rule": rule})


_RULES = {
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
    "string_type": "must be text",
    "too_long": "has {actual_length} values, at most {max_length} belong here",
    "too_short": "has {actual_length} values, at least {min_length} belong here",
}
"""Our words for pydantic's error types; their fields are numbers and texts of the format, nothing of the file."""


def broken_format(where: Path | str, error: ValidationError) -> InputError:
    """Pydantic's error in our words.

    Args:
        where: File, or the name of what is built in Python.
        error: What its validation raised.
    """
    details = error.errors(include_url=False)
    # of the alternatives of a union, the one whose error lies deepest is the one that was meant
    first = max(
        details,
        key=lambda detail: (
            _keys(detail)[:1] == _keys(details[0])[:1],
            detail["type"] not in {"list_type", "model_type", "float_type"},
            len(detail["loc"]),
        ),
    )
    key = ""
    for part in _keys(first):
        key += f"[{part}]" if isinstance(part, int) else f".{part}" if key else part
    kind = first["type"]
    rule = _RULES[kind].format(**first.get("ctx", {})) if kind in _RULES else first["msg"]
    told = kind in {"missing", "rule"}
    if first["input"] is None and not told:
        rule += " (it is empty)"
    return InputError(where, f"{rule.rstrip('.')}.", key=key, value=None if told else first["input"])


def _keys(detail: ErrorDetails) -> list[str | int]:
    """The location without the names that pydantic gives to the alternatives of a union."""
    kinds = {"float", "int", "str", "bool"}
    return [
        part
        for part in detail["loc"]
        if isinstance(part, int) or (re.fullmatch(r"[a-z_0-9]+|[A-Z]", part) and part not in kinds)
    ]

# SPDX-License-Identifier: MIT
"""Strict reading of YAML input files: every mistake becomes one `InputError` with file, key, value and rule."""

import difflib
import re
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidatorFunctionWrapHandler, model_validator
from pydantic_core import ErrorDetails, PydanticCustomError

from mrts.errors import InputError

MAX_FILE_BYTES = 30_000_000
"""Far above any cell, motion, URDF or generated C file: a larger one is a mistake."""

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
            for key in data:
                if key not in cls.model_fields:
                    close = difflib.get_close_matches(str(key), cls.model_fields, n=1)
                    hint = f"; did you mean '{close[0]}'?" if close else ""
                    raise PydanticCustomError(
                        "unknown_key",
                        "unknown key '{key}'{hint} The keys here are: {known}",
                        {"key": str(key), "hint": hint or ".", "known": ", ".join(cls.model_fields)},
                    )
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


class _StrictLoader(yaml.SafeLoader):
    """SafeLoader that refuses duplicate keys and reads numbers as YAML 1.2 does: `1e-3` is one, `1:30` is none."""

    yaml_implicit_resolvers = {  # noqa: RUF012 (PyYAML's own class attribute)
        first: [(tag, pattern) for tag, pattern in resolvers if not tag.endswith((":int", ":float"))]
        for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:  # noqa: FBT001, FBT002 (PyYAML's signature)
        seen: set[str] = set()
        for key_node, _ in node.value:
            key = str(key_node.value)
            if key in seen:
                raise yaml.constructor.ConstructorError(
                    problem=f"the key '{key}' stands twice", problem_mark=key_node.start_mark
                )
            seen.add(key)
        return super().construct_mapping(node, deep)


_StrictLoader.add_implicit_resolver("tag:yaml.org,2002:int", re.compile(r"^[-+]?[0-9]+$"), list("-+0123456789"))
_StrictLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^([-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$"),
    list("-+0123456789."),
)

Model = TypeVar("Model", bound=StrictModel)


def read_text(path: Path, what: str) -> str:
    """Text of an input file.

    Args:
        path: The file.
        what: What the file is, for the message: "cell file".

    Raises:
        InputError: If it is missing, a folder, unreadable, too large, or not UTF-8.
    """
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise InputError(path, f"a {what} has at most {MAX_FILE_BYTES} bytes.")
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError(path, f"there is no such {what}{_neighbour(path)}") from None
    except UnicodeDecodeError:
        raise InputError(path, f"this {what} is not UTF-8 text.") from None
    except (OSError, ValueError) as error:  # ValueError: a null byte in the path
        raise InputError(path, f"this {what} cannot be read: {getattr(error, 'strerror', error)}.") from None


def _neighbour(path: Path) -> str:
    """End of the sentence that says that there is no such file."""
    try:
        names = [other.name for other in path.parent.iterdir()]
    except OSError:
        return f": the folder {path.parent} is missing or cannot be read."
    close = difflib.get_close_matches(path.name, names, n=1)
    return f"; did you mean '{path.with_name(close[0])}'?" if close else ". Check the path."


def read_model(path: Path, model: type[Model], what: str) -> Model:
    """Read and validate a YAML file.

    Args:
        path: The file.
        model: The format that it must have.
        what: What the file is, for messages: "cell file".

    Raises:
        InputError: If the file is missing, not YAML, or breaks a rule of the format.
    """
    text = read_text(path, what)
    try:
        data = yaml.load(text, Loader=_StrictLoader)  # noqa: S506 (a SafeLoader)
    except (yaml.YAMLError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        place = f" at line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        problem = getattr(error, "problem", None) or "it cannot be parsed"
        raise InputError(path, f"this {what} is not valid YAML{place}: {problem}.") from None
    except ValueError as error:
        raise InputError(path, f"this {what} holds a value that YAML cannot read: {error}.") from None
    if not isinstance(data, dict):
        raise InputError(
            path, f"a {what} is a mapping of keys to values ({', '.join(model.model_fields)}).", value=data
        )
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise _input_error(path, error.errors(include_url=False)) from None


def broken_rule(rule: str) -> PydanticCustomError:
    """An error for a validator to raise: a rule that its sentence explains by itself, without the value."""
    return PydanticCustomError("rule", "{rule}", {"rule": rule})


_RULES = {
    "dict_type": "must be a mapping of keys to values",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "greater_than": "must be > {gt:g}",
    "greater_than_equal": "must be >= {ge:g}",
    "int_type": "must be a whole number",
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
"""Our words for pydantic's error types."""


def _input_error(path: Path, details: list[ErrorDetails]) -> InputError:
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
    rule = _RULES.get(first["type"], first["msg"]).format(**first.get("ctx", {}))
    told = first["type"] in {"missing", "unknown_key", "rule"}
    if first["input"] is None and not told:
        rule += " (it is empty)"
    return InputError(path, f"{rule.rstrip('.')}.", key=key, value=None if told else first["input"])


def _keys(detail: ErrorDetails) -> list[str | int]:
    """The location without the names that pydantic gives to the alternatives of a union."""
    kinds = {"float", "int", "str", "bool"}
    return [
        part
        for part in detail["loc"]
        if isinstance(part, int) or (re.fullmatch(r"[a-z_0-9]+", part) and part not in kinds)
    ]

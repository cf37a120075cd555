# SPDX-License-Identifier: MIT
"""Formats that pydantic checks: every mistake becomes one `InputError` with file, key, value and rule."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Self, cast

from pydantic import BaseModel, ConfigDict, ValidationError, ValidatorFunctionWrapHandler, model_validator
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from mrts.base.errors import InputError
from mrts.base.formats.broken_record import RULES, BrokenRecordError, broken_record, key_text, unknown_key


class StrictModel(BaseModel):
    """Base of the file formats: unknown keys are refused with the known ones, types are not coerced."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    @classmethod
    def read(cls, where: Path | str, data: dict[Any, Any]) -> Self:
        """The format that a mapping of a file describes; arguments and errors as `Record.read`."""
        try:
            return cls.model_validate(data)
        except ValidationError as error:
            raise broken_format(where, data, error) from None
        except InputError as error:  # of a format that can also be built in Python
            raise InputError(where, error.rule, key=error.key, value=error.value) from None

    @model_validator(mode="wrap")
    @classmethod
    def _name_unknown_keys(cls, data: Any, handler: ValidatorFunctionWrapHandler) -> Self:
        fields = [field.alias or name for name, field in cls.model_fields.items()]
        unknown = [key for key in data if key not in fields] if isinstance(data, dict) else []
        if not unknown:
            model: Self = handler(data)
            return model
        wrong = [InitErrorDetails(type=broken_rule(unknown_key(key, fields)), input=None) for key in unknown]
        try:
            handler({key: value for key, value in data.items() if key not in unknown})
        except ValidationError as error:
            wrong += [_as_raised(detail) for detail in error.errors(include_url=False)]
        raise ValidationError.from_exception_data(cls.__name__, wrong)


def _as_raised(detail: ErrorDetails) -> InitErrorDetails:
    """What an error is made of, from what it says."""
    context = detail.get("ctx", {})
    kind = PydanticCustomError(detail["type"], "{rule}", context) if "rule" in context else detail["type"]
    return InitErrorDetails(type=kind, loc=detail["loc"], input=detail["input"], ctx=context)


def broken_rule(rule: str) -> PydanticCustomError:
    """An error for a validator to raise: a rule that its sentence explains by itself, without the value.

    Args:
        rule: May quote what a user wrote: it is the value of a field, and never read as a template.
    """
    return PydanticCustomError("rule", "{rule}", {"rule": rule})


def broken_format(where: Path | str, data: object, error: ValidationError) -> InputError:
    """Pydantic's error in our words: the first mistake, with all others.

    Args:
        where: File, or the name of what is built in Python.
        data: What was validated.
        error: What its validation raised.
    """
    found = [_located(data, detail) for detail in error.errors(include_url=False)]
    first, *others = (each for one in _meant(found) for each in _in_words(where, one).each())
    return first.with_others(others)


@dataclass(frozen=True)
class _Located:
    """An error, its keys in the data, and how many of them stand before each alternative of a union, by its name."""

    detail: ErrorDetails
    keys: tuple[str | int, ...]
    alternatives: tuple[tuple[int, str], ...]


def _located(data: object, detail: ErrorDetails) -> _Located:
    keys: list[str | int] = []
    alternatives: list[tuple[int, str]] = []
    at, parts = data, detail["loc"]
    for place, part in enumerate(parts):
        missing = detail["type"] == "missing" and place == len(parts) - 1
        if missing or (isinstance(at, dict) and part in at) or (isinstance(at, list) and isinstance(part, int)):
            keys.append(part)
            at = None if missing else cast("Any", at)[part]
        else:  # the name that pydantic gives to an alternative of a union
            alternatives.append((len(keys), str(part)))
    return _Located(detail, tuple(keys), tuple(alternatives))


def _meant(found: list[_Located], depth: int = 0) -> list[_Located]:
    """What is left of the errors if, of the alternatives of each union, only the one that was meant counts.

    It is the one whose errors lie deepest.

    Args:
        found: Errors.
        depth: Alternatives that have been chosen.
    """
    unions: dict[Any, list[_Located]] = {}
    for place, one in enumerate(found):
        inside = len(one.alternatives) > depth
        union = (one.keys[: one.alternatives[depth][0]],) if inside else place
        unions.setdefault(union, []).append(one)
    meant = []
    for union, errors in unions.items():
        if isinstance(union, int):
            meant += errors
            continue
        best = max(errors, key=partial(_depth, depth=depth))
        meant += _meant([one for one in errors if one.alternatives[depth] == best.alternatives[depth]], depth + 1)
    return meant


def _depth(one: _Located, depth: int) -> tuple[bool, bool, int]:
    inside = len(one.keys) > one.alternatives[depth][0]
    return inside, one.detail["type"] not in {"list_type", "model_type", "float_type"}, len(one.detail["loc"])


def _in_words(where: Path | str, one: _Located) -> InputError:
    kind, context = one.detail["type"], one.detail.get("ctx", {})
    if kind == "record":
        inner: BrokenRecordError = context["error"]
        for each in inner.each():
            each.keys = (*one.keys, *each.keys)
        return broken_record(where, inner)
    rule = RULES[kind].format(**context) if kind in RULES else one.detail["msg"]
    told = kind in {"missing", "rule"}
    if one.detail["input"] is None and not told:
        rule += " (it is empty)"
    return InputError(
        where, f"{rule.rstrip('.')}.", key=key_text(one.keys), value=None if told else one.detail["input"]
    )

# SPDX-License-Identifier: MIT
"""Formats that pydantic checks: every mistake becomes one `InputError` with file, key, value and rule."""

import re
from pathlib import Path
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, ValidationError, ValidatorFunctionWrapHandler, model_validator
from pydantic_core import ErrorDetails, PydanticCustomError

from mrts.base.errors import InputError
from mrts.base.formats.record import RULES, BrokenRecordError, broken_record, key_text, unknown_key


class StrictModel(BaseModel):
    """Base of the file formats: unknown keys are refused with the known ones, types are not coerced."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    @classmethod
    def read(cls, where: Path | str, data: dict[Any, Any]) -> Self:
        """The format that a mapping of a file describes; arguments and errors as `Record.read`."""
        try:
            return cls.model_validate(data)
        except ValidationError as error:
            raise broken_format(where, error) from None
        except InputError as error:  # of a format that can also be built in Python
            raise InputError(where, error.rule, key=error.key, value=error.value) from None

    @model_validator(mode="wrap")
    @classmethod
    def _name_unknown_keys(cls, data: Any, handler: ValidatorFunctionWrapHandler) -> Self:
        if isinstance(data, dict):
            fields = [field.alias or name for name, field in cls.model_fields.items()]
            for key in data:
                if key not in fields:
                    raise broken_rule(unknown_key(key, fields))
        model: Self = handler(data)
        return model


def broken_rule(rule: str) -> PydanticCustomError:
    """An error for a validator to raise: a rule that its sentence explains by itself, without the value.

    Args:
        rule: May quote what a user wrote: it is the value of a field, and never read as a template.
    """
    return PydanticCustomError("rule", "{rule}", {"rule": rule})


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
    kind, context = first["type"], first.get("ctx", {})
    if kind == "record":
        inner: BrokenRecordError = context["error"]
        inner.keys = (*_keys(first), *inner.keys)
        return broken_record(where, inner)
    key = key_text(_keys(first))
    rule = RULES[kind].format(**context) if kind in RULES else first["msg"]
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

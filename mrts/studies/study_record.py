# SPDX-License-Identifier: MIT
"""What `study.json` must hold for a study to be read from it."""

import json
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from mrts.base.errors import InputError
from mrts.base.formats.strict_model import broken_format, broken_rule

FORMAT = 1
"""Of study.json."""

ANSWERS = {"status": "string", "reason": "string", "c2_lower": "float64", "c2_upper": "float64"}
ANSWERS |= {"lower_limit": "string", "upper_limit": "string", "duration": "float64"}
"""Columns of every study behind the number of a variant and what varies, and their types."""


class _Recorded(BaseModel):
    """Base of what is recorded; keys that are only told to people are not looked at."""

    model_config = ConfigDict(extra="ignore", strict=True, frozen=True)


class _Column(_Recorded):
    type: Literal["int64", "float64", "string"]
    unit: str


class _Vary(_Recorded):
    path: str
    unit: str
    text: str
    spread: dict[str, Any]


class _Cell(_Recorded):
    name: str


class _Asked(_Recorded):
    file: str
    cell: _Cell
    question: dict[str, bool | float | str | None]
    vary: list[_Vary]
    sample: str
    seed: int


class _Record(_Recorded):
    digest: str
    variants: Annotated[int, Field(ge=1)]
    chunk: Annotated[int, Field(ge=1)]
    columns: dict[str, _Column]
    study: _Asked

    @model_validator(mode="after")
    def _has_its_columns(self) -> Self:
        types = {"variant": "int64"} | {each.path: "float64" for each in self.study.vary} | ANSWERS
        for name, kind in types.items():
            if name not in self.columns or self.columns[name].type != kind:
                raise broken_rule(f"there must be a column '{name}' of type {kind}")
        return self


def study_record(path: Path, text: str) -> dict[str, Any]:
    """What a `study.json` holds.

    Args:
        path: The file, for messages.
        text: Its text.

    Raises:
        InputError: If it is damaged, or of another format.
    """
    try:
        record = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(path, f"is damaged: {error}. Remove the folder, or name another.") from None
    if not isinstance(record, dict) or record.get("format") != FORMAT:
        raise InputError(path, f"is not a study of format {FORMAT}, which this mrts reads; name another folder.")
    try:
        _Record.model_validate(record)
    except ValidationError as error:
        broken = broken_format(path, record, error)
        rule = f"is damaged: {broken.rule} Remove the folder, or name another."
        raise InputError(path, rule, key=broken.key, value=broken.value) from None
    return record

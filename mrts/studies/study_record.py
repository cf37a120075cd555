# SPDX-License-Identifier: MIT
"""What `study.json` must hold for a study to be read from it."""

import json
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from mrts.base.errors import InputError
from mrts.base.formats.record import Record, Rule

FORMAT = 1
"""Of study.json."""

ANSWERS = {"status": "string", "reason": "string", "c2_lower": "float64", "c2_upper": "float64"}
ANSWERS |= {"lower_limit": "string", "upper_limit": "string", "duration": "float64"}
"""Columns of every study behind the number of a variant and what varies, and their types."""


class _Recorded(Record):
    """Base of what is recorded; keys that are only told to people are not looked at."""

    @classmethod
    def model_validate(cls, data: object) -> Self:
        known = {key: data[key] for key in cls.model_fields if key in data} if isinstance(data, dict) else data
        return super().model_validate(known)


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


class _Whole(_Recorded):
    digest: str
    variants: Annotated[int, Rule(ge=1)]
    chunk: Annotated[int, Rule(ge=1)]
    columns: dict[str, _Column]
    study: _Asked

    def problem(self) -> str:
        types = {"variant": "int64"} | {each.path: "float64" for each in self.study.vary} | ANSWERS
        for name, kind in types.items():
            if name not in self.columns or self.columns[name].type != kind:
                return f"there must be a column '{name}' of type {kind}"
        return ""


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
        _Whole.model_validate(record)
    except InputError as error:
        rule = f"is damaged: {error.rule} Remove the folder, or name another."
        raise InputError(path, rule, key=error.key, value=error.value) from None
    return record

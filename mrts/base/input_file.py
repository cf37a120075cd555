# SPDX-License-Identifier: MIT
"""Reading of input files: text of a sound size, and the numbers that may stand in it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from mrts.base.errors import InputError
from mrts.base.regular_file import read_regular
from mrts.base.yaml_text import MAX_YAML_BYTES, MAX_YAML_DEPTH, parse_yaml

MAX_FILE_BYTES = 30_000_000
"""Far above any cell, motion, URDF or generated C file: a larger one is a mistake."""

MAX_URDF_BYTES = 3_000_000

LARGEST_NUMBER = 1e12
"""Largest magnitude of a number in an input file, in SI units: anything larger is a mistake and would overflow."""

SMALLEST_NUMBER = 1e-100
"""Smallest size of a number that is not 0, but for coordinates: what is divided by it stays far from overflow."""

IDENTIFIER = r"^[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*$"
"""Letters, digits and single underscores: what C, file names and CasADi all accept."""

LONGEST_NAME = 40


KEYS_OF = {
    "cell file": {"name", "gravity", "plane", "object", "robots"},
    "motion file": {"duration", "samples", "profile", "start", "end", "waypoints", "file", "joints"},
    "study file": {"cell", "motion", "vary", "sample", "count"},
}
"""Keys that only one kind of file has."""

XML = ("<?xml", "<robot", "<mujoco", "<sdf")

CLEARLY_OTHER = 2
"""Keys of another kind of file, and none of its own, that tell what a file is."""

Format = TypeVar("Format")
"""A record or a model that a file holds: it can `read` a mapping."""


def read_text(path: Path, what: str, most: int = MAX_FILE_BYTES) -> str:
    """Text of an input file, with Unix line ends.

    Raises:
        InputError: If it is missing, no regular file, unreadable, too large, or not UTF-8.
    """
    return text_of(path, what, read_regular(path, what, most))


def text_of(path: Path, what: str, content: bytes) -> str:
    """Text of an input file's bytes, with Unix line ends; arguments as `read_text`."""
    try:
        text = content.decode()
    except UnicodeDecodeError:
        raise InputError(path, f"this {what} is not UTF-8 text; are two files swapped?") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_model(path: Path, model: type[Format], what: str) -> Format:
    """Read and validate a YAML file.

    Raises:
        InputError: If the file is missing, not YAML, or breaks a rule of the format.
    """
    return validated(path, read_data(path, what), model, what)


def read_data(path: Path, what: str) -> Any:
    """What a YAML file says, not yet validated; arguments as `read_model`.

    Raises:
        InputError: If the file is missing, or not YAML.
    """
    text = read_text(path, what, MAX_YAML_BYTES)
    if text.lstrip("\ufeff \n").startswith(XML):
        raise InputError(path, f"this is XML, and a {what} belongs here; `mrts new DIR --robot URDF` makes one.")
    try:
        return parse_yaml(text)
    except ValueError as error:
        raise InputError(path, f"this {what} {error}.") from None


def validated(where: Path | str, data: object, model: type[Format], what: str) -> Format:
    """What a file or a dictionary says, validated.

    Raises:
        InputError: If it breaks a rule of the format.
    """
    form: Any = model
    if isinstance(data, dict):
        _check_kind(where, data, what)
    else:
        rule = f"a {what} is a mapping of keys to values ({', '.join(form.model_fields)})."
        raise InputError(where, rule, value=data)
    read: Format = form.read(where, data)
    return read


def _check_kind(where: Path | str, data: dict[Any, Any], what: str) -> None:
    """Refuse a file of another kind by what it is: two that were given in the wrong order, rather than unknown keys."""
    if what in KEYS_OF and not KEYS_OF[what] & data.keys():
        for other, keys in KEYS_OF.items():
            if len(keys & data.keys()) >= CLEARLY_OTHER:
                is_study = other == "study file"
                taken = "`mrts sweep` takes it." if is_study else "are two files swapped?"
                raise InputError(where, f"this is a {other}, and a {what} belongs here: {taken}")


def plain(where: str, data: object, depth: int = MAX_YAML_DEPTH) -> object:
    """A value as a YAML file could hold it: numpy's arrays and numbers, tuples and paths become lists, numbers, text.

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

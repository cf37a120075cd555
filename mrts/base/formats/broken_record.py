# SPDX-License-Identifier: MIT
"""What is wrong with the values of a file, in words: rules, keys, and many mistakes beside each other."""

from collections.abc import Sequence
from pathlib import Path

from mrts.base.errors import InputError

RULES = {
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
    "string_too_short": "must have at least {min_length} character",
    "string_type": "must be text",
    "too_long": "has {actual_length} values, at most {max_length} belong here",
    "too_near_zero": "must be 0, or at least {smallest:g} in size",
    "too_short": "has {actual_length} values, at least {min_length} belong here",
}
"""What is wrong with a value, by pydantic's names; fields are numbers and texts of the format, nothing of the file."""

Key = str | int


class BrokenRecordError(ValueError):
    """A value breaks a rule.

    Attributes:
        keys: Where it is.
        rule: What it breaks.
        value: The value.
        told: Whether the rule explains itself without the value.
        others: What else is wrong beside it.
    """

    def __init__(self, rule: str, value: object = None, *, told: bool = False) -> None:
        super().__init__(rule)
        self.keys: tuple[Key, ...] = ()
        self.rule, self.value, self.told = rule, value, told
        self.others: tuple[BrokenRecordError, ...] = ()

    def each(self) -> "tuple[BrokenRecordError, ...]":
        """This one, and what else is wrong."""
        return (self, *self.others)


class Wrong:
    """Everything that is wrong beside each other."""

    def __init__(self) -> None:
        self._errors: list[BrokenRecordError] = []

    def add(self, error: BrokenRecordError) -> None:
        """Add an error, with what else is wrong beside it."""
        self._errors += error.each()

    def raise_added(self) -> None:
        """Go on if there is none.

        Raises:
            BrokenRecordError: The first, with all others.
        """
        if self._errors:
            first, *others = self._errors
            first.others = tuple(others)
            for other in others:
                other.others = ()
            raise first


def broken_record(where: Path | str, error: BrokenRecordError) -> InputError:
    """An error of a record in the words of an input file, with what else is wrong.

    Args:
        where: File, or the name of what is built in Python.
        error: What its check raised.
    """
    first, *others = (_broken(where, each) for each in error.each())
    return first.with_others(others)


def _broken(where: Path | str, error: BrokenRecordError) -> InputError:
    rule = error.rule + (" (it is empty)" if error.value is None and not error.told else "")
    value = None if error.told else error.value
    return InputError(where, f"{rule.rstrip('.')}.", key=key_text(error.keys), value=value)


def key_text(keys: Sequence[Key]) -> str:
    """Where a value is, such as "robots[0].name"."""
    text = ""
    for part in keys:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def unknown_key(key: object, known: list[str]) -> str:
    """The rule that a key breaks which a format does not have."""
    import difflib  # noqa: PLC0415 (for this message only)

    close = difflib.get_close_matches(str(key), known, n=1)
    hint = f"; did you mean '{close[0]}'?" if close else ""
    return f"unknown key '{key}'{hint or '.'} The keys here are: {', '.join(known)}"

# SPDX-License-Identifier: MIT
"""What users are told: the exceptions of mrts, remarks beside an answer, checks of arguments, text safe to show.

An infeasible motion is an outcome (`mrts.ScalingStatus`), never an exception. What raises is wrong input
and a tool that failed. Every message names the value, the rule and what to do. It is safe to print as it is: what it
quotes is escaped, and cut where it is very long.
"""

import re
import reprlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from html import escape
from importlib.util import find_spec
from math import inf, isfinite
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, cast

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

LONGEST_WORD = 300

LONGEST_MESSAGE = 4000

Progress = Callable[[int, int], None]
"""Told how many of how many pieces of work are done."""

Severity = Literal["hint", "warning", "assumption"]
"""How much it matters: a likely mistake, what to know before trusting an answer, or what is taken for granted, which is
told by a check alone."""

NEAREST_INERTIA = "inertia-nearest"
"""Code of the remark on an inertia of a URDF that was moved to the nearest one of a body."""

WORDS = {
    "Mapping": "a dictionary",
    "NoneType": "None",
    "PathLike": "a Path",
    "bool": "True or False",
    "float": "a number",
    "int": "a whole number",
    "str": "text",
}

_VALUES = reprlib.Repr()
_VALUES.maxstring = _VALUES.maxother = 120  # a name whole; of a longer path its middle is left out


class MrtsError(Exception):
    """Root of every exception that mrts raises on purpose."""

    has_lines: ClassVar[bool] = False

    def __init__(self, message: str) -> None:
        super().__init__(message_text(message, lines=self.has_lines))


class InputError(MrtsError):
    """A file, a key or an argument breaks a rule.

    Args:
        where: File, or the name of the argument in the Python API.
        rule: What must hold, and what to do; a sentence.
        key: Path of the key inside the file, such as `robots[0].torque`.
        value: The offending value; left out of the message when None.
        others: What else is wrong, as `mrts check` lists it.
    """

    def __init__(
        self, where: Path | str, rule: str, *, key: str = "", value: object = None, others: "Sequence[InputError]" = ()
    ) -> None:
        self.where = str(where)
        self.key = key
        self.value = value
        self.rule = rule
        self.others = tuple(others)
        subject = self.where
        if key:
            subject += f": {key}"
        if value is not None:
            subject += f" = {_shown(value)}"
        more = f" And {len(self.others)} more: 'mrts check' lists all that is wrong at once." if self.others else ""
        super().__init__(f"{subject}: {rule}{more}")

    def with_others(self, others: "Sequence[InputError]") -> "InputError":
        """The same error, which carries others."""
        return InputError(self.where, self.rule, key=self.key, value=self.value, others=others)

    def inside(self, where: Path | str, key: str = "") -> "InputError":
        """The same error, and those that it carries, told of a file, and of what is below a key of it."""
        first, *others = (InputError(where, one.rule, key=joined(key, one.key), value=one.value) for one in self.each())
        return first.with_others(others)

    def each(self) -> "tuple[InputError, ...]":
        """This error by itself, then those that it carries."""
        return (self.with_others(()), *self.others)

    def __reduce__(self) -> tuple[object, ...]:
        # an exception pickles as its message alone, which this constructor does not take: a pool of workers would die
        again = partial(type(self), key=self.key, value=self.value, others=self.others)
        return again, (self.where, self.rule)


def joined(key: str, inner: str) -> str:
    """A key and what is below it, such as "robots[0].name" of "robots" and "[0].name"."""
    return f"{key}.{inner}" if key and inner and not inner.startswith("[") else f"{key}{inner}"


def did_you_mean(wrong: str, known: Iterable[str]) -> str:
    """End of a sentence that refuses a name, with the known one that is nearest."""
    import difflib  # noqa: PLC0415 (for messages only)

    close = difflib.get_close_matches(wrong, known, n=1)
    return f"; did you mean '{close[0]}'?" if close else "."


class Mistakes:
    """All that is wrong at once: notes what independent checks refuse, in order, and raises it as one error.

    Attributes:
        found: So far, each mistake once.
    """

    def __init__(self, first: "Iterable[InputError]" = ()) -> None:
        self.found: list[InputError] = []
        self._said: set[str] = set()
        for error in first:
            self.add(error)

    @contextmanager
    def noted(self) -> Iterator[None]:
        """Note an error of what is done inside, with what it carries, and go on after it."""
        try:
            yield
        except InputError as error:
            self.add(error)

    def add(self, error: InputError) -> None:
        """Note an error with what it carries."""
        for each in error.each():
            if str(each) not in self._said:
                self._said.add(str(each))
                self.found.append(each)

    def raise_noted(self) -> None:
        """Go on if there is none."""
        if self.found:
            first, *others = self.found
            raise first.with_others(others)


class MotionError(MrtsError):
    """The joints cannot follow the object's path: out of reach, singular, or off the plane."""


class CompilerError(MrtsError):
    """The C compiler failed, or there is none.

    Lines that the compiler printed stay lines.
    """

    has_lines = True


class SolverError(MrtsError):
    """No solver returned an answer that passes its own verification."""


@dataclass(frozen=True)
class Remark:
    """One entry of "warnings" in the JSON result.

    Attributes:
        code: Stable name of its kind, such as "not-at-rest", for programs.
        text: A sentence for people.
        sample: Where along the motion, None if it is about all of it.
        severity: How much it matters.
    """

    code: str
    text: str
    sample: int | None = None
    severity: Severity = "warning"

    @staticmethod
    def hint(code: str, text: str) -> "Remark":
        """A likely mistake."""
        return Remark(code, text, severity="hint")

    @staticmethod
    def assumed(code: str, text: str) -> "Remark":
        """What is taken for granted."""
        return Remark(code, text, severity="assumption")

    def __str__(self) -> str:
        return f"{self.severity}: {printable(self.text)}"

    def to_json(self) -> dict[str, Any]:
        """Code, severity, text and sample."""
        return {"code": self.code, "severity": self.severity, "text": self.text, "sample": self.sample}


def check_type(name: str, value: object, *kinds: type) -> None:
    """Check what an argument is."""
    if isinstance(value, kinds) and (bool in kinds or not isinstance(value, bool)):
        return
    *others, last = (WORDS.get(kind.__name__, f"of type {kind.__name__}") for kind in kinds)
    allowed = f"{', '.join(others)} or {last}" if others else last
    given = "None" if value is None else f"of type {type(value).__name__}"
    inside = " Give its `retimed`." if isinstance(getattr(value, "retimed", object()), kinds) else ""
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


def as_array(name: str, value: object) -> "NDArray[np.float64]":
    """An argument of the Python API as an array of numbers, its own unless nobody can write to the one given."""
    import numpy as np  # noqa: PLC0415 (so that `mrts --help` does without)

    if type(value) is np.ndarray and value.dtype == np.float64 and value.base is None and not value.flags.writeable:
        return value
    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(name, "must be numbers of one rectangular shape.", value=value) from None


def printable(text: str, *, lines: bool = False) -> str:
    r"""Text without control characters, marks of direction, and signs that cannot be seen: written as \u001b.

    The escapes are those of JSON, so that JSON stays JSON.
    """
    if text.isprintable():
        return text
    return "".join(letter if letter.isprintable() or (lines and letter == "\n") else _escape(letter) for letter in text)


def message_text(text: str, *, lines: bool = False) -> str:
    """A message for people: printable, and without the middle of what is very long."""
    words = re.sub(rf"\S{{{LONGEST_WORD + 1},}}", lambda word: cut(word.group(), LONGEST_WORD), text)
    return printable(cut(words, LONGEST_MESSAGE), lines=lines)


def cut(text: str, longest: int) -> str:
    """Text whose middle is left out where it is too long."""
    return text if len(text) <= longest else f"{text[: longest // 2]}…{text[-(longest // 2 - 1) :]}"


def _escape(letter: str) -> str:
    short = {"\n": "\\n", "\r": "\\r", "\t": "\\t"}.get(letter)
    if short is not None:
        return short
    units = letter.encode("utf-16-be", "surrogatepass")
    return "".join(f"\\u{units[at : at + 2].hex()}" for at in range(0, len(units), 2))


def html_text(text: str) -> str:
    """Text for the content of an HTML element or between quotes in a tag: without markup, printable."""
    return escape(printable(text, lines=True))


def _shown(value: object) -> str:
    if hasattr(value, "tolist"):  # numbers of numpy
        value = cast("Any", value).tolist()
    try:
        shown = _VALUES.repr(value)
    except ValueError:  # Python writes no whole number of more than some thousand digits
        return f"a {type(value).__name__} too long to show"
    return " ".join(line.strip() for line in shown.splitlines())

# SPDX-License-Identifier: MIT
"""The exceptions of mrts.

An infeasible motion is an outcome (`mrts.ScalingStatus`), never an exception. What raises is wrong input
and a tool that failed. Every message names the value, the rule and what to do. It is safe to print as it is: what it
quotes is escaped, and cut where it is very long.
"""

import reprlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, cast

from mrts.base.printable import message_text

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


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


def _shown(value: object) -> str:
    if getattr(value, "shape", None) == ():  # a number of numpy
        value = cast("Any", value).item()
    try:
        shown = _VALUES.repr(value)
    except ValueError:  # Python writes no whole number of more than some thousand digits
        return f"a {type(value).__name__} too long to show"
    return " ".join(line.strip() for line in shown.splitlines())


def as_array(name: str, value: object) -> "NDArray[np.float64]":
    """An argument of the Python API as an array of numbers, its own unless nobody can write to the one given."""
    import numpy as np  # noqa: PLC0415 (so that `mrts --help` does without)

    if type(value) is np.ndarray and value.dtype == np.float64 and value.base is None and not value.flags.writeable:
        return value
    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(name, "must be numbers of one rectangular shape.", value=value) from None


class MotionError(MrtsError):
    """The joints cannot follow the object's path: out of reach, singular, or off the plane."""


class CompilerError(MrtsError):
    """The C compiler failed, or there is none.

    Lines that the compiler printed stay lines.
    """

    has_lines = True


class SolverError(MrtsError):
    """No solver returned an answer that passes its own verification."""

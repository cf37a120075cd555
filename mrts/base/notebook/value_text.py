# SPDX-License-Identifier: MIT
"""A value in a few words, as a cell of a table."""

from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from itertools import islice
from pathlib import Path

import numpy as np

from mrts.base.arrays import Array
from mrts.base.printable import cut

MOST_NUMBERS = 10
"""Of an array that is written out."""

MOST_ENTRIES = 6
"""Of a tuple or a mapping that is written out."""

LONGEST = 240
"""Letters of a cell."""


def value_text(value: object) -> str:
    """A value in a few words; never a long array.

    Args:
        value: Any.
    """
    return cut(_text(value), LONGEST)


def _text(value: object) -> str:  # noqa: PLR0911 (one line a kind of value)
    if value is None:
        return "none"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, int | float | np.number):
        return _number(float(value))
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, str | Path):
        return str(value)
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, Mapping):
        return _entries(len(value), (f"{key}: {_inner(entry)}" for key, entry in value.items()))
    if isinstance(value, Sequence):
        return _entries(len(value), (_inner(value[place]) for place in range(len(value))))
    return _inner(value)


def _inner(value: object) -> str:
    """A value among others: the name of its class where it has no words of its own."""
    if isinstance(value, np.ndarray | Mapping) or (isinstance(value, Sequence) and not isinstance(value, str)):
        return _array(value) if isinstance(value, np.ndarray) else f"{len(value)} {type(value).__name__} entries"
    if value is None or isinstance(value, bool | int | float | np.generic | str | Path | Enum):
        return _text(value)
    return words_of(value) or type(value).__name__


def words_of(value: object) -> str:
    """What a class writes of its values in words of its own, not as Python or as an address; empty without such words.

    Args:
        value: Any.
    """
    kind = type(value)
    if any("__str__" in vars(one) for one in kind.__mro__[:-1]):
        return str(value)
    made = getattr(kind, "__dataclass_params__", None)
    own = made is not None and not made.repr and any("__repr__" in vars(one) for one in kind.__mro__[:-1])
    return repr(value).removeprefix("<").removesuffix(">") if own else ""


def _number(value: float) -> str:
    if np.isinf(value):
        return "∞" if value > 0 else "-∞"
    return f"{value:.6g}"


def _array(value: Array) -> str:
    if value.ndim == 1 and value.size <= MOST_NUMBERS:
        return f"({', '.join(_text(entry) for entry in value)})"
    shape = f"Shape ({', '.join(map(str, value.shape))}{',' if value.ndim == 1 else ''})"
    known = np.issubdtype(value.dtype, np.floating) and value.size and not np.isnan(value).any()
    return f"{shape}, {_number(float(value.min()))} … {_number(float(value.max()))}" if known else shape


def _entries(count: int, texts: Iterator[str]) -> str:
    """All of a few; of many the first two, as finding the others may take time."""
    if not count:
        return "none"
    return ", ".join(texts) if count <= MOST_ENTRIES else f"{count}: {', '.join(islice(texts, 2))}, …"

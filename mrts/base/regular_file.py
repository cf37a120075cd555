# SPDX-License-Identifier: MIT
"""Opening a file that a user names: a regular one of a sound size, or a clear sentence, and never a wait."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import BinaryIO

from mrts.base.errors import InputError

FLAGS = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0)
"""Nothing that stands at the path by then may make us wait or become our terminal."""

NEIGHBOURS = 1000

FILES_READ: set[str] = set()
"""Of this process, by their real paths: what a command has read, none of its outputs may overwrite."""

is_folder, is_file = os.path.isdir, os.path.isfile
"""Of a path that a user names: one that no file can have, such as a name that is too long, is none of them."""

KINDS = {"d": "a folder", "p": "a pipe", "s": "a socket", "c": "a device", "b": "a device"}
"""By the first letter of `stat.filemode`."""


@contextmanager
def open_regular(path: Path, what: str, most: int) -> Iterator[BinaryIO]:
    """Open an input file for reading.

    What is checked is what is read: the same open file, whatever happens to the path meanwhile.

    Raises:
        InputError: If it is missing, no regular file, too large, or cannot be read.
    """
    try:
        _require_regular(path, what, path.stat(), most)  # a device may act on being opened
        with os.fdopen(os.open(path, FLAGS), "rb") as file:
            _require_regular(path, what, os.fstat(file.fileno()), most)
            FILES_READ.add(os.path.realpath(path))
            yield file
    except FileNotFoundError:
        raise InputError(path, f"there is no such {what}{neighbour(path)}") from None
    except (OSError, ValueError) as error:  # ValueError: a null byte in the path
        raise InputError(path, f"this {what} cannot be read: {getattr(error, 'strerror', error)}.") from None


def read_regular(path: Path, what: str, most: int) -> bytes:
    """All of an input file; arguments and errors as `open_regular`."""
    with open_regular(path, what, most) as file:
        content = file.read(most + 1) or b""  # a file of the kernel may grow as it is read, or have nothing yet
    if len(content) > most:
        raise _too_large(path, what, most)
    return content


def _require_regular(path: Path, what: str, status: os.stat_result, most: int) -> None:
    if not stat.S_ISREG(status.st_mode):
        kind = KINDS.get(stat.filemode(status.st_mode)[0], "no file")
        advice = "" if kind == "a folder" else " Copy what it gives into one."
        raise InputError(path, f"is {kind}; a {what} is a regular file.{advice}")
    if status.st_size > most:
        raise _too_large(path, what, most)


def _too_large(path: Path, what: str, most: int) -> InputError:
    return InputError(path, f"a {what} has at most {most} bytes.")


def neighbour(path: Path) -> str:
    """End of the sentence that says that there is no such file: one of nearly its name, or what to do."""
    try:
        names = [other.name for other in islice(path.parent.iterdir(), NEIGHBOURS)]
    except OSError:
        return f": the folder {path.parent} is missing or cannot be read."
    import difflib  # noqa: PLC0415 (for this message only)

    stems = difflib.get_close_matches(path.stem, {Path(name).stem for name in names}, n=1)  # most end alike
    alike = [name for name in sorted(names) if Path(name).stem in stems]
    close = difflib.get_close_matches(path.name, alike, n=1, cutoff=0)
    return f"; did you mean '{path.with_name(close[0])}'?" if close else ". Check the path."

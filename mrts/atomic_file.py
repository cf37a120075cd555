# SPDX-License-Identifier: MIT
"""Output files are written whole or not at all."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from mrts.errors import InputError


def write_atomically(path: Path, write: Callable[[Path], object], *, private: bool = False) -> None:
    """Let `write` fill a temporary file beside `path`, then rename it into place.

    Args:
        path: The file to make or replace; missing folders are made. What a link points to is replaced, not the link;
            a device or a pipe is written into.
        write: Fills the temporary file whose path it is given.
        private: Whether nobody else may read or write the file, and a link is replaced itself; else the user's umask
            decides.

    Raises:
        InputError: If the folder cannot be made or written.
    """
    path = path.absolute() if private else path.resolve()
    try:
        if path.exists() and not path.is_file():
            write(path)  # a device or a pipe cannot be replaced
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}.", suffix=path.suffix)
    except OSError as error:
        raise InputError(path, f"cannot be written: {error.strerror}.") from None
    os.close(handle)
    temporary = Path(name)
    try:
        write(temporary)
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o600 if private else 0o666 & ~umask)
        temporary.replace(path)
    except OSError as error:
        raise InputError(path, f"cannot be written: {error.strerror}.") from None
    finally:
        temporary.unlink(missing_ok=True)


def write_text_atomically(path: Path, text: str, *, private: bool = False) -> None:
    """Write `text` as UTF-8 with Unix line ends, whole or not at all; otherwise as `write_atomically`.

    Raises:
        InputError: If the folder cannot be made or written.
    """

    def write(temporary: Path) -> None:
        temporary.write_text(text, encoding="utf-8", newline="\n")

    write_atomically(path, write, private=private)

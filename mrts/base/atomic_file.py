# SPDX-License-Identifier: MIT
"""Output files are written whole or not at all, and several that belong together all or none."""

import json
import os
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from mrts.base.errors import InputError, MrtsError, as_path

LONGEST_START = 300
"""Bytes of a generated file among which stands what says that it is."""

Write = Callable[[Path], object]
"""Fills the file, or makes the folder, whose path it is given."""


def write_atomically(path: Path, write: Write, *, private: bool = False) -> None:
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
    write_together({path: write}, private=private)


def is_marked(path: Path, mark: str) -> bool:
    """Whether a file begins with what marks it as generated; what cannot be read is not."""
    try:
        with path.open("rb") as file:
            return mark.encode() in file.read(LONGEST_START)
    except OSError:
        return False


def check_own(path: Path, *, own: bool) -> None:
    """Refuse to write over a file that is there and was not written by the same command.

    Raises:
        InputError: If it is.
    """
    if path.exists() and not own:
        raise InputError(path, "is another's file, which would be lost: name a new or empty folder, or move the file.")


def write_together(files: Mapping[Path, Write], *, private: bool = False) -> None:
    """Write several files, all or none: none is renamed into place before all are filled.

    Args:
        files: What `write_atomically` takes; they are renamed in this order.
        private: Likewise.

    Raises:
        InputError: If one cannot be written; then all are as they were, and no folder has been made.
    """
    with ExitStack() as stack:
        filled: list[tuple[Path, Path | None, Write]] = []
        for given, write in files.items():
            path = given.absolute() if private else resolved_path(given)
            with told_of(path):
                temporary = None if _is_special(path) else stack.enter_context(_temporary_file(path))
                if temporary is not None:
                    _fill(temporary, write, private=private)
            filled.append((path, temporary, write))
        for path, temporary, write in filled:
            with told_of(path):
                if temporary is None:
                    write(path)  # a device or a pipe cannot be replaced
                else:
                    temporary.replace(path)


def write_text_atomically(path: Path, text: str, *, private: bool = False) -> None:
    """Write `text` as UTF-8 with Unix line ends, whole or not at all; otherwise as `write_atomically`."""
    write_atomically(path, text_writer(text), private=private)


def text_writer(text: str) -> Write:
    """What writes `text` as UTF-8 with Unix line ends."""
    data = text.encode("utf-8", "backslashreplace")  # a path need not be text
    return lambda path: path.write_bytes(data)


class JsonOutput(ABC):
    """Writes what `to_json` says."""

    @abstractmethod
    def to_json(self) -> dict[str, Any]:
        """All of it as JSON values."""

    def json_text(self) -> str:
        """`to_json` as text."""
        return json.dumps(self.to_json(), allow_nan=False, ensure_ascii=False)

    def write_json(self, path: Path | str) -> None:
        """Write `json_text` to a file, whole or not at all."""
        write_text_atomically(as_path("path", path), self.json_text() + "\n")


def make_folder_atomically(folder: Path, make: Write) -> None:
    """Let `make` make a temporary folder beside `folder`, then rename it into place.

    Raises:
        InputError: If it cannot be made; then no other folder has been made either.
    """
    folder = resolved_path(folder)
    with (
        told_of(folder),
        _made(folder.parent),
        tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}") as temporary,
    ):
        made = Path(temporary) / folder.name
        make(made)
        made.rename(folder)


def check_writable(path: Path) -> None:
    """Try whether a file can be written, and leave nothing behind: to be known before long work.

    Raises:
        InputError: If it cannot.
    """
    target = resolved_path(path)
    with told_of(target):
        if _is_special(target):
            return  # to open it may wait for a reader
        with _temporary_file(target):
            pass


def resolved_path(path: Path) -> Path:
    """Where a file is that is to be written, links followed."""
    try:
        return path.resolve()
    except (OSError, RuntimeError, ValueError) as error:
        raise InputError(path, f"cannot be written: {getattr(error, 'strerror', None) or error}.") from None


def _is_special(path: Path) -> bool:
    return path.exists() and not path.is_file() and not path.is_dir()


@contextmanager
def told_of(path: Path) -> Iterator[None]:
    """Tell what keeps a file from being written of its path."""
    try:
        yield
    except MrtsError:
        raise
    except Exception as error:
        cause = _system_error(error)
        if cause is None:
            raise
        raise InputError(path, f"cannot be written: {cause.strerror or cause}.") from None


def _system_error(error: BaseException | None) -> OSError | None:
    """What the system said: a writer that stumbles over a full disk raises something else on top."""
    while error is not None and not isinstance(error, OSError):
        error = error.__context__
    return error


@contextmanager
def _made(folder: Path) -> Iterator[None]:
    """A folder and those above it; the ones that were missing go again if nothing was put into them."""
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    finally:
        for each in missing:
            with suppress(OSError):  # it holds something
                each.rmdir()


@contextmanager
def _temporary_file(path: Path) -> Iterator[Path]:
    if path.is_dir():
        raise InputError(path, "cannot be written: it is a folder; name a file.")
    with _made(path.parent):
        temporary = path.parent / f".{path.stem}.{os.urandom(8).hex()}{path.suffix}"
        try:  # first: Ctrl-C may come between the file and what takes it away
            temporary.touch(mode=0o600, exist_ok=False)
            yield temporary
        finally:
            temporary.unlink(missing_ok=True)


def _fill(temporary: Path, write: Write, *, private: bool) -> None:
    write(temporary)
    umask = os.umask(0)
    os.umask(umask)
    temporary.chmod(0o600 if private else 0o666 & ~umask)

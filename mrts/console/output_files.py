# SPDX-License-Identifier: MIT
"""The files that a verb is asked for: tried before the work, and each written whatever becomes of the others."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType

from mrts.base.atomic_file import check_writable
from mrts.base.errors import InputError, MrtsError
from mrts.console.exit_codes import BAD_INPUT
from mrts.console.terminal import fail

PROBE = "mrts-probe"
"""A file that is tried, but not left, in a folder that is to be written."""


def check_outputs(
    files: Mapping[str, Path | None],
    folders: Mapping[str, Path | None] = MappingProxyType({}),
    new_folders: Mapping[str, Path | None] = MappingProxyType({}),
) -> None:
    """Fail before any work if an output cannot be written, or two are one.

    Args:
        files: Files by option; None is not asked for.
        folders: Likewise, folders that get files.
        new_folders: Likewise, folders that must not exist.

    Raises:
        InputError: Names the option, or the file and why it cannot be written.
    """
    given: dict[str, Path] = {}
    for option, path in (*files.items(), *folders.items(), *new_folders.items()):
        if path is None or (str(path) == "-" and option == "--json"):
            continue
        if str(path) == "-":
            raise InputError(option, "writes a file; only --json takes '-' for standard output.", value="-")
        if same := [other for other in given if given[other] == path]:
            raise InputError(option, f"names the same file as {same[0]}.", value=str(path))
        given[option] = path
    for option, path in given.items():
        if option in folders and path.exists() and not path.is_dir():
            raise InputError(option, "names a file, but writes a folder.", value=str(path))
        if option in new_folders and path.exists():
            raise InputError(path, "exists already: a bag is written into a new folder. Remove it, or name another.")
        _check_writable(path, PROBE if option not in files else "")


def _check_writable(path: Path, inside: str) -> None:
    """Raise if an output cannot be written, in its own name.

    Args:
        path: As the user named it.
        inside: A file in it that is tried, where it is a folder.
    """
    try:
        check_writable(path / inside)
    except InputError as error:
        raise InputError(path, error.rule) from None


class Outputs:
    """What became of the outputs."""

    def __init__(self) -> None:
        self.failed = False
        self.written: list[Path] = []
        self.defect: Exception | None = None

    @contextmanager
    def attempt(self, path: Path) -> Iterator[None]:
        """Write one output; if that fails, say so and go on.

        Args:
            path: The file, or the folder that gets files.
        """
        before = _files(path)
        try:
            yield
            self.written += sorted(file for file, state in _files(path).items() if before.get(file) != state)
        except MrtsError as error:
            self.failed = True
            fail(f"error: {error}")
        except Exception as error:  # noqa: BLE001 (raised again by `raise_defect`)
            self.defect = self.defect or error

    def lines(self) -> Iterator[str]:
        """What was written, a line a file."""
        if self.written:
            yield "\nwritten:"
            yield from (f"  {path}" for path in self.written)

    def raise_defect(self) -> None:
        """Raise what no writer should have raised, if one did."""
        if self.defect is not None:
            raise self.defect

    def code(self, outcome: int) -> int:
        """The exit code, once the answer has been printed.

        Args:
            outcome: What it is if all outputs were written.
        """
        self.raise_defect()
        return BAD_INPUT if self.failed else outcome


def _files(path: Path) -> dict[Path, tuple[int, int]]:
    """A file, or the files right in a folder and in those in it, each with what changes when it is written."""
    found = [path, *path.glob("*"), *path.glob("*/*")] if path.is_dir() else [path]
    states = ((file, file.stat()) for file in found if not file.is_dir() and file.exists())
    return {file: (state.st_ino, state.st_mtime_ns) for file, state in states}

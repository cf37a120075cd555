# SPDX-License-Identifier: MIT
"""The answer of a command: files that it is asked for, words or JSON, and an exit code."""

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType

from mrts.base.atomic_file import JsonOutput
from mrts.base.errors import InputError, MrtsError
from mrts.base.regular_file import FILES_READ
from mrts.commands.console.terminal import Style, fail, put, say

FEASIBLE, INFEASIBLE, BAD_INPUT = 0, 1, 2
"""Exit codes; `mrts.cli` has those of commands that end without an answer."""

NOTES = ("note:", "warning:", "hint:")
"""How a line of an answer begins that is a note."""


def check_not_read(path: Path) -> None:
    """Check that an output is no file that the command has read."""
    if os.path.realpath(path) in FILES_READ:
        raise InputError(path, "is a file that this command has read: not written. Name another.")


class Outputs:
    """The outputs of a command, each written whatever becomes of the others.

    Args:
        found: The answer, of a command that has `--json`.
        json: What `--json` names; a file is written now.
    """

    def __init__(self, found: JsonOutput | None = None, json: Path | None = None) -> None:
        self.failed = False
        self.written: list[Path] = []
        self.json_text = found.json_text if found is not None and str(json) == "-" else None
        if found is not None and json is not None and self.json_text is None:
            self.write(json, found.write_json)

    def write(self, path: Path, write: Callable[[Path], object]) -> None:
        """Write one output, a file or a folder; if that fails, say so and go on."""
        try:
            check_not_read(path)
            write(path)
            self.written.append(path)
        except MrtsError as error:
            self.failed = True
            fail(f"error: {error}")

    def answer(self, lines: Iterable[str], outcome: int, styles: Mapping[str, Style] = MappingProxyType({})) -> int:
        """Print the answer in words with what was written, or as JSON where `--json -` asks for that; the exit code.

        Args:
            lines: In words, the outcome first.
            outcome: The exit code if all outputs were written.
            styles: Of lines that have one of their own.
        """
        if self.json_text is not None:
            put(self.json_text())
        else:
            first: Style = "strong" if outcome == FEASIBLE else "bad"
            told = list(lines)
            for number, line in enumerate(told):
                say(line, first if number == 0 else "note" if line.startswith(NOTES) else styles.get(line, "plain"))
            if self.written:
                say("\n".join([*([""] if told else []), "written:", *(f"  {path}" for path in self.written)]))
        return BAD_INPUT if self.failed else outcome

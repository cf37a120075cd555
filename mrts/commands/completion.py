# SPDX-License-Identifier: MIT
"""Completion in the shell, by argcomplete (extra `terminal`)."""

import argparse
import os

SUFFIXES = {
    "cell": ("yaml", "yml"),
    "motion": ("yaml", "yml", "csv", "mcap"),
    "recording": ("csv", "mcap", "db3"),
    "result": ("npz",),
    "json": ("json",),
    "csv": ("csv",),
}
"""Of the files that an argument takes; one that takes a folder has the metavar DIR."""


def is_completing() -> bool:
    """Whether it is the shell that asks."""
    return "_ARGCOMPLETE" in os.environ


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer the shell and leave, if it is the shell that asks.

    Args:
        parser: Of the command line.
    """
    if not is_completing():
        return
    from argcomplete import autocomplete
    from argcomplete.completers import DirectoriesCompleter, FilesCompleter

    for action in _actions(parser):
        if action.metavar == "DIR":
            action.completer = DirectoriesCompleter()  # type: ignore[attr-defined]  # argcomplete's own protocol
        elif action.dest in SUFFIXES:
            action.completer = FilesCompleter(SUFFIXES[action.dest])  # type: ignore[attr-defined]  # likewise
    autocomplete(parser)


def _actions(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """All arguments of all verbs."""
    found = []
    for action in parser._actions:  # noqa: SLF001 (argparse has no public list, argcomplete reads this one too)
        verbs = action.choices.values() if isinstance(action, argparse._SubParsersAction) else ()  # noqa: SLF001
        found += [action, *(inner for verb in verbs for inner in _actions(verb))]
    return found

"""The command line: in this process, which has imported what it needs, or in one of its own, as a user runs it."""

import contextlib
import ctypes
import logging
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass

from mrts.cli import main

STREAMS = {"stdout": 1, "stderr": 2}


@dataclass(frozen=True)
class Answer:
    """Exit code, and all that was written to the standard streams."""

    returncode: int
    stdout: str
    stderr: str


def mrts_command(*arguments, cwd="."):
    """What the command line answers; what a library in C writes to its streams is caught as well."""
    with tempfile.TemporaryFile("w+b") as out, tempfile.TemporaryFile("w+b") as err:
        with contextlib.chdir(cwd), _fresh_log(), _into(out, "stdout"), _into(err, "stderr"):
            code = main([*map(str, arguments)])
        return Answer(code, *(_text(file) for file in (out, err)))


def mrts_process(*arguments, **options):
    """The same in a process of its own, where environment, limits or the process itself matter."""
    command = [sys.executable, "-m", "mrts", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


def mrts_without(package, *arguments):
    """The command line in a process that lacks a package."""
    script = (
        "import importlib.util, sys; found = importlib.util.find_spec;"
        f"importlib.util.find_spec = lambda name, *rest: None if name == '{package}' else found(name, *rest);"
        "from mrts.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", script, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@contextlib.contextmanager
def _fresh_log():
    """As in a new process, where the command line has not yet said who prints remarks."""
    root = logging.getLogger()
    before, root.handlers = root.handlers, []
    try:
        yield
    finally:
        root.handlers = before


@contextlib.contextmanager
def _into(file, name):
    """Lead a standard stream of Python and of C into a file."""
    number, before = STREAMS[name], getattr(sys, name)
    before.flush()
    kept = os.dup(number)
    os.dup2(file.fileno(), number)
    with open(number, "w", encoding="utf-8", closefd=False) as stream:
        setattr(sys, name, stream)
        try:
            yield
        finally:
            stream.flush()
            ctypes.CDLL(None).fflush(None)
            os.dup2(kept, number)
            os.close(kept)
            setattr(sys, name, before)


def _text(file):
    file.seek(0)
    return file.read().decode()

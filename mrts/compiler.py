# SPDX-License-Identifier: MIT
"""Generated C to a shared library, with the system's C compiler."""

import os
import shlex
import shutil
import subprocess  # fixed flags, no shell, the command is the user's own CC
from pathlib import Path

from mrts.atomic_file import write_atomically
from mrts.errors import CompilerError

FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared", "-ffp-contract=off")
"""No contraction to fused multiply-add, so that compiled C equals CasADi's virtual machine."""

CANDIDATES = ("cc", "gcc", "clang")
SHOWN_LINES = 6


def find_compiler() -> tuple[str, ...] | None:
    """Command of the C compiler: the environment's CC, else the first of cc, gcc, clang; None if there is none.

    Raises:
        CompilerError: If CC names a program that is not there.
    """
    named = os.environ.get("CC", "").strip()
    if named:
        try:
            command = tuple(shlex.split(named))
        except ValueError as error:
            raise CompilerError(f"the environment variable CC = {named!r} cannot be read: {error}.") from None
        if shutil.which(command[0]) is None:
            raise CompilerError(
                f"the environment variable CC = {named!r} names no program on this machine. Install it, or unset CC."
            )
        return command
    return next(((name,) for name in CANDIDATES if shutil.which(name)), None)


def compile_library(command: tuple[str, ...], source: Path, library: Path) -> None:
    """Compile `source` into the shared library `library`, which is the user's only, whole or not at all.

    Args:
        command: Compiler, from `find_compiler`.
        source: C file.
        library: File to make or replace.

    Raises:
        CompilerError: If the compiler fails.
    """

    def run(output: Path) -> None:
        arguments = [*command, *FLAGS, str(source), "-o", str(output), "-lm"]
        try:
            done = subprocess.run(arguments, capture_output=True, text=True, errors="replace", check=False)  # noqa: S603
        except OSError as error:
            raise CompilerError(
                f"the C compiler cannot be run: {error.strerror}: {command[0]}. Set CC to a working C compiler."
            ) from None
        if done.returncode != 0:
            said = [line for line in (done.stderr or done.stdout).splitlines() if line.strip()][:SHOWN_LINES]
            raise CompilerError(
                f"the C compiler failed with exit code {done.returncode}: {shlex.join(arguments)}\n"
                + "\n".join(said or ["(it printed nothing)"])
                + "\nSet CC to a working C compiler."
            )

    write_atomically(library, run, private=True)

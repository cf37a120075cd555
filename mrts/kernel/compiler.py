# SPDX-License-Identifier: MIT
"""C to shared libraries, with the system's compiler, on first use; kept per user under a hash of text and compiler."""

import ctypes
import hashlib
import os
import shlex
import shutil
import signal
import subprocess  # fixed flags, no shell, the command is the user's own CC
from functools import cache
from pathlib import Path

from mrts.base.atomic_file import write_atomically, write_text_atomically
from mrts.base.errors import CompilerError
from mrts.kernel.binding import bind
from mrts.kernel.cache_folder import cache_folder, only_ours

FLAGS = ("-std=c99", "-O1", "-fPIC", "-shared", "-ffp-contract=off", "-Wno-psabi")
"""No contraction to fused multiply-add, so that compiled C equals CasADi's own evaluation. Vectors are passed between
functions of one library only, so how they are passed is no matter. With -O2 a cell compiles half as long again, and
answers as fast: linear programs take 5 % less, whole calls the same."""

PROCESSOR = 4096
"""Bytes of /proc/cpuinfo that describe the first processor."""

CANDIDATES = ("cc", "gcc", "clang")
SHOWN_LINES = 6
ADVICE = "Set CC to a working C compiler."

PATIENCE = 600.0
"""The longest that a compiler may take [s]: a cell takes a few seconds, and a minute on a small board."""


@cache
def flags(command: tuple[str, ...]) -> tuple[str, ...]:
    """`FLAGS`, and the wider registers of an x86-64 machine that says it has them: the same numbers, sooner.

    gcc compiles a cell in nine tenths of the time without one of its passes, to the same instructions.
    """
    try:
        with Path("/proc/cpuinfo").open("rb") as file:
            has_wide = b" avx2 " in file.read(PROCESSOR)
    except OSError:  # elsewhere than on Linux what is called gcc may be clang, which has no such pass
        return FLAGS
    is_gcc = "gcc" in Path(shutil.which(command[0]) or "").resolve().name
    return (*FLAGS, *["-mavx2"] * has_wide, *["-fno-tree-ccp"] * is_gcc)


def find_compiler() -> tuple[str, ...]:
    """Command of the C compiler: the environment's CC, else the first of cc, gcc, clang.

    Raises:
        CompilerError: If there is none, or CC names a program that is not there.
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
    for name in CANDIDATES:
        if shutil.which(name):
            return (name,)
    raise CompilerError(
        "there is no C compiler, which whatever is computed of a cell takes. Install one (Debian: apt-get install gcc "
        "libc6-dev), or set CC."
    )


def compile_library(command: tuple[str, ...], source: Path, library: Path) -> None:
    """Compile a C file into a shared library, which is the user's only, whole or not at all.

    Raises:
        CompilerError: If the compiler fails.
    """

    def run(output: Path) -> None:
        arguments = [*command, *flags(command), str(source), "-o", str(output), "-lm"]
        code, said = _run(arguments)
        problem = f"failed with exit code {code}" if code else "succeeded, but made no library"
        if code or not output.is_file():
            told = "\n".join(said.strip().splitlines()[:SHOWN_LINES] or ["(it printed nothing)"])
            raise CompilerError(f"the C compiler {problem}: {shlex.join(arguments)}\n{told}\n{ADVICE}")

    write_atomically(library, run, private=True)


def _run(arguments: list[str]) -> tuple[int, str]:
    try:
        process = subprocess.Popen(  # noqa: S603
            arguments,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            errors="replace",
            process_group=0,
        )
    except OSError as error:
        return error.errno or 1, f"it cannot be started: {error.strerror}"
    with process:
        try:
            output, errors = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            return signal.SIGTERM, f"it was not done after {PATIENCE:g} s and was stopped"
        finally:
            if process.returncode is None:  # too slow, or Ctrl-C: its own children end with it
                os.killpg(process.pid, signal.SIGTERM)
    return process.returncode, errors or output


def compiled_library(name: str, source: str, files: tuple[str, ...] = ()) -> ctypes.CDLL:
    """The library of a C text, opened from the cache, or compiled where it is missing or cannot be opened.

    Args:
        name: Of its files, an identifier.
        source: The C text.
        files: Those of mrts/kernel/c in it whose functions are bound.

    Raises:
        CompilerError: If there is no compiler, or it fails, or makes what cannot be opened.
    """
    command = find_compiler()
    text = "\0".join((source, *command, *flags(command))).encode()
    library = cache_folder("lib", hashlib.sha256(text).hexdigest()) / f"{name}.so"
    for missing in (not only_ours(library), True):
        if missing:
            write_text_atomically(library.with_suffix(".c"), source, private=True)
            compile_library(command, library.with_suffix(".c"), library)
        try:
            return bind(ctypes.CDLL(str(library)), files)
        except (OSError, AttributeError) as error:
            problem = error
    raise CompilerError(
        f"what compiler {' '.join(command)} made of {name} cannot be loaded: {problem}. Set CC to a working one."
    )

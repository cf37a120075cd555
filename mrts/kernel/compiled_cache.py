# SPDX-License-Identifier: MIT
"""Shared libraries compiled on first use, kept per user under a hash of their C text and compiler."""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import CompilerError
from mrts.kernel.cache_folder import cache_folder, only_ours
from mrts.kernel.compiler import compile_library, flags

Library = TypeVar("Library")


def library_or_rebuilt(
    command: tuple[str, ...], name: str, source: str, open_library: Callable[[Path], Library]
) -> Library:
    """Open a library from the cache; a damaged one is compiled again.

    Args:
        command: Compiler, from `find_compiler`.
        name: Of its files.
        source: Its C text.
        open_library: Raises OSError where the file cannot be opened, AttributeError where it lacks a function.

    Raises:
        CompilerError: If the compiler fails, or makes what cannot be opened.
    """
    try:
        return open_library(library_in_cache(command, name, source))
    except (OSError, AttributeError):
        pass
    try:
        return open_library(library_in_cache(command, name, source, rebuild=True))
    except (OSError, AttributeError) as error:
        raise CompilerError(
            f"what compiler {' '.join(command)} made of {name} cannot be loaded: {error}. Set CC to a working one."
        ) from None


def library_in_cache(command: tuple[str, ...], name: str, source: str, *, rebuild: bool = False) -> Path:
    """Shared library of a C text, compiled unless the cache holds it.

    Args:
        command: Compiler, from `find_compiler`.
        name: Of its files, an identifier.
        source: The C text.
        rebuild: Compile even if the cache holds it (the library in it cannot be opened).

    Raises:
        CompilerError: If the compiler fails.
    """
    text = "\0".join((source, *command, *flags())).encode()
    library = cache_folder("lib", hashlib.sha256(text).hexdigest()) / f"{name}.so"
    seal = library.with_suffix(".sha256")
    if rebuild or not _is_whole(library, seal):
        file = library.with_suffix(".c")
        write_text_atomically(file, source, private=True)
        compile_library(command, file, library)
        write_text_atomically(seal, hashlib.sha256(library.read_bytes()).hexdigest(), private=True)
    return library


def _is_whole(library: Path, seal: Path) -> bool:
    """Whether a library is the one that was compiled here: a damaged one can crash the process that opens it.

    The seal tells damage, not malice: that nobody else could write the file does.
    """
    if not only_ours(library):
        return False
    try:
        return hashlib.sha256(library.read_bytes()).hexdigest() == seal.read_text(encoding="ascii")
    except (OSError, ValueError):
        return False

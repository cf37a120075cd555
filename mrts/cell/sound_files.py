# SPDX-License-Identifier: MIT
"""Files of the cache, taken only if they are ours, whole, and what they say they are."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from mrts.base.errors import InputError
from mrts.base.manifest import ChainsRecord, check_source
from mrts.kernel.cache_folder import only_ours

Record = TypeVar("Record", bound=ChainsRecord)


def if_sound(path: Path, read: Callable[[str], Record]) -> Record | None:
    """What a file of the cache holds; None where it is missing or damaged.

    Args:
        path: The file.
        read: Reads and checks its text.
    """
    try:
        return read(path.read_text(encoding="utf-8")) if only_ours(path) else None
    except (InputError, ValueError):
        return None


def is_source(path: Path, chains: ChainsRecord) -> bool:
    """Whether a C file of the cache is there and whole.

    Args:
        path: The file.
        chains: What it was generated for.
    """
    if not only_ours(path):
        return False
    try:
        check_source(path, chains, path.read_text(encoding="utf-8"))
    except (InputError, ValueError):
        return False
    return True

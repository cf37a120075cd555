# SPDX-License-Identifier: MIT
"""The user's own cache: what lies in it is compiled and run, so nobody else may be able to write there."""

import logging
import os
import stat
import tempfile
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

from mrts.base.errors import InputError

ADVICE = "Set MRTS_CACHE_DIR to a folder that only you can write."
WRITTEN_BY_OTHERS = stat.S_IWGRP | stat.S_IWOTH
logger = logging.getLogger("mrts")


def cache_folder(*inside: str) -> Path:
    """A private folder in the cache, made if missing.

    The cache is `MRTS_CACHE_DIR`, else `XDG_CACHE_HOME`/mrts, else ~/.cache/mrts. Where another user could write that,
    or where there is no home to write to, it is a temporary folder that goes when the process ends, and a warning says
    so.

    Raises:
        InputError: If it cannot be made.
    """
    named = os.environ.get("MRTS_CACHE_DIR")
    try:
        folder = (Path(named) if named else _default_cache()).resolve()
        for part in ("", *inside):
            folder /= part
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not only_ours(folder, stat.S_ISDIR):
                problem = f"{folder} is a link, belongs to another user or can be written by others"
                break
        else:
            return folder
    except (OSError, RuntimeError) as error:  # RuntimeError: there is no home folder
        problem = f"it cannot be made: {error}"
        if named:
            raise InputError(named, f"the cache folder cannot be made: {error}. {ADVICE}") from None
    _warn(problem)
    folder = Path(_temporary_cache().name).resolve().joinpath(*inside)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def only_ours(path: Path, is_kind: Callable[[int], bool] = stat.S_ISREG) -> bool:
    """Whether a path is a regular file, or of another kind, that this user or root owns and nobody else can write.

    Args:
        path: In a folder from `cache_folder`, so that nobody can exchange the file between this look and its use.
        is_kind: Of `stat`, asked of its mode.
    """
    try:
        found = path.lstat()
    except OSError:
        return False
    return is_kind(found.st_mode) and found.st_uid in {os.geteuid(), 0} and not found.st_mode & WRITTEN_BY_OTHERS


def _default_cache() -> Path:
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (base if base.is_absolute() else Path.home() / ".cache") / "mrts"  # as the XDG specification wants it


@lru_cache
def _warn(problem: str) -> None:
    logger.warning("the cache is not used, because %s: every run generates and compiles anew. %s", problem, ADVICE)


@lru_cache
def _temporary_cache() -> tempfile.TemporaryDirectory[str]:
    try:
        return tempfile.TemporaryDirectory(prefix="mrts-", ignore_cleanup_errors=True)
    except OSError as error:
        raise InputError(tempfile.gettempdir(), f"no temporary folder can be made: {error}. {ADVICE}") from None

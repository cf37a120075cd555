# SPDX-License-Identifier: MIT
"""The user's own cache: what lies in it is compiled and run, so nobody else may be able to write there."""

import atexit
import logging
import os
import shutil
import stat
import tempfile
from functools import lru_cache
from pathlib import Path

from mrts.base.errors import InputError

ADVICE = "Set MRTS_CACHE_DIR to a folder that only you can write."
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
    base, problem = Path(named) if named else _default_cache(), "there is no home folder"
    if base is not None:
        try:
            _make_private(base)
            base = base.resolve()
            problem = _problem(base, inside)
            if not problem:
                _make_private(base.joinpath(*inside))
                return base.joinpath(*inside)
        except OSError as error:
            if named:
                raise InputError(base, f"the cache folder cannot be made: {error.strerror}. {ADVICE}") from None
            problem = f"{base} cannot be made: {error.strerror}"
    _warn(problem)
    folder = _temporary_cache().joinpath(*inside)
    _make_private(folder)
    return folder


def only_ours(path: Path) -> bool:
    """Whether a file is a regular one that this user or root owns and nobody else can write.

    Args:
        path: In a folder from `cache_folder`, so that nobody can exchange the file between this look and its use.
    """
    try:
        found = path.lstat()
    except OSError:
        return False
    return stat.S_ISREG(found.st_mode) and _writers_problem(found) == ""


def _default_cache() -> Path | None:
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if not base.is_absolute():  # as the XDG specification wants it
        try:
            base = Path.home() / ".cache"
        except RuntimeError:
            return None
    return base / "mrts" if base.is_absolute() else None


@lru_cache
def _warn(problem: str) -> None:
    logger.warning("the cache is not used, because %s: every run generates and compiles anew. %s", problem, ADVICE)


def _make_private(folder: Path) -> None:
    for missing in reversed([above for above in (folder, *folder.parents) if not above.exists()]):
        missing.mkdir(mode=0o700, exist_ok=True)
    if not folder.is_dir():
        folder.mkdir()  # raises what is wrong


def _problem(base: Path, inside: tuple[str, ...]) -> str:
    """Why others could put files into a folder of the cache; empty if they cannot.

    From the root down: what is found in a folder stays, if nobody else can write the folders above it.
    """
    for above in reversed(base.parents):
        if problem := _writers_problem(above.stat(), above=True):
            return f"{above} {problem}"
    for folder in (base, *(base.joinpath(*inside[: depth + 1]) for depth in range(len(inside)))):
        if folder.is_symlink():
            return f"{folder} is a link"
        if folder.exists() and (problem := _writers_problem(folder.stat())):
            return f"{folder} {problem}"
    return ""


def _writers_problem(found: os.stat_result, *, above: bool = False) -> str:
    """Who else than this user and root may change a file or folder; empty if nobody.

    Where there are no numbers for users (Windows), folders of the user's profile are private by their access lists.

    Args:
        found: Of the file or folder.
        above: A folder above the cache may also belong to who owns `/` (root, or who stands for it in a container), and
            may be written by others if these cannot rename what is not theirs, such as /tmp.
    """
    if not hasattr(os, "geteuid"):
        return ""
    owners = {os.geteuid(), 0, Path("/").stat().st_uid} if above else {os.geteuid(), 0}
    if found.st_uid not in owners:
        return "belongs to another user"
    if above and found.st_mode & stat.S_ISVTX:
        return ""
    if found.st_mode & stat.S_IWOTH or (found.st_mode & stat.S_IWGRP and not _is_own_group(found.st_gid)):
        return "can be written by other users"
    return ""


@lru_cache
def _is_own_group(number: int) -> bool:
    """Whether a group is the user's private one, as many systems make for each user: nobody else is in it."""
    import grp  # noqa: PLC0415 (not on Windows)
    import pwd  # noqa: PLC0415

    try:
        user, group = pwd.getpwuid(os.geteuid()), grp.getgrgid(number)
    except KeyError:
        return False
    return number == user.pw_gid and group.gr_name == user.pw_name and {*group.gr_mem} <= {user.pw_name}


@lru_cache
def _temporary_cache() -> Path:
    above = Path(tempfile.gettempdir()).resolve()
    try:
        folder = Path(tempfile.mkdtemp(prefix="mrts-", dir=above))
    except OSError as error:
        raise InputError(above, f"no temporary folder can be made: {error.strerror}. {ADVICE}") from None
    atexit.register(_remove, folder, os.getpid())
    if problem := _problem(folder, ()):
        raise InputError(above, f"this is no place for compiled code: {problem}. {ADVICE}")
    return folder


def _remove(folder: Path, process: int) -> None:
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)

# SPDX-License-Identifier: MIT
"""Reading arrays from an .npz file that may be damaged or hostile: sizes are checked before anything is unpacked."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from mrts.base.errors import InputError
from mrts.base.regular_file import open_regular

MAX_ARCHIVE_BYTES = 2_000_000_000
"""A million samples of two arms take less than half of it."""

UNPACKED_BYTES = 30_000_000
UNPACKED_RATIO = 50
"""An archive may unpack to so many bytes and so many times its own size: results shrink to about a third, nothing but
zeros to a thousandth."""


@contextmanager
def open_arrays(path: Path, what: str, advice: str) -> Iterator[tuple[dict[str, NDArray[Any]], int]]:
    """The arrays of an .npz file by name, none that would have to be unpickled, and its size in bytes.

    Raises:
        InputError: If it is missing, no regular file, no such archive, or damaged; also of what the block raises.
    """
    with open_regular(path, what, MAX_ARCHIVE_BYTES) as file:
        try:
            size = file.seek(0, os.SEEK_END)
            with ZipFile(file) as archive:
                unpacked = sum(member.file_size for member in archive.infolist())
            if unpacked > UNPACKED_BYTES + UNPACKED_RATIO * size:
                raise ValueError(f"it would unpack to {unpacked} bytes")  # noqa: TRY301
            file.seek(0)
            with np.load(file) as arrays:
                yield dict(arrays), size
        except Exception as error:
            if isinstance(error, InputError) and error.where == str(path):
                raise
            raise InputError(path, f"is no {what} of mrts, or damaged ({error}). {advice}") from None

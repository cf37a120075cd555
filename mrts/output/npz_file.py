# SPDX-License-Identifier: MIT
"""Reading arrays from an .npz file that may be damaged or hostile: sizes are checked before anything is unpacked."""

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile

import numpy as np
from numpy.lib.format import read_array, read_array_header_1_0, read_array_header_2_0, read_magic
from numpy.typing import NDArray

from mrts.base.errors import InputError
from mrts.base.regular_file import open_regular

MAX_ARCHIVE_BYTES = 2_000_000_000
"""A million samples of two arms take less than half of it."""

UNPACKED_BYTES = 30_000_000
UNPACKED_RATIO = 50
"""An archive may unpack to so many bytes and so many times its own size: results shrink to about a third, nothing but
zeros to a thousandth."""

END_RECORD = b"PK\x05\x06"
END_BYTES = 22
END_64_LOCATOR = b"PK\x06\x07"
LOCATOR_BYTES = 20
DIRECTORY_BYTES = 100_000
"""Of the list of members; that of a result takes some thousand."""


class ArrayArchive:
    """An open archive.

    Attributes:
        names: Of its arrays.
        size: Of the file in bytes.
    """

    def __init__(self, path: Path, archive: ZipFile, size: int) -> None:
        self.names = [name.removesuffix(".npy") for name in archive.namelist()]
        self.size = size
        self._path, self._archive, self._left = path, archive, UNPACKED_BYTES + UNPACKED_RATIO * size

    def read(self, name: str, most: int | None = None) -> NDArray[Any]:
        """One array; none that would have to be unpickled.

        Raises:
            InputError: If it is too large.
        """
        member = self._archive.getinfo(f"{name}.npy")
        self._left -= member.file_size
        if self._left < 0 or (most is not None and member.file_size > most):
            raise InputError(
                self._path, f"would unpack to {member.file_size} bytes: more than an archive of this size.", key=name
            )
        if member.compress_type not in {ZIP_STORED, ZIP_DEFLATED}:
            raise InputError(self._path, "is packed in a way that numpy does not use.", key=name)
        content = self._archive.read(member)  # all of it, so that its checksum is compared, but not more than declared
        return _array(content)


@contextmanager
def open_arrays(path: Path, what: str, advice: str) -> Iterator[ArrayArchive]:
    """Open an .npz file.

    Raises:
        InputError: If it is missing, no regular file, no such archive, or damaged; also of what its reading raises.
    """
    with open_regular(path, what, MAX_ARCHIVE_BYTES) as file:
        try:
            size = _checked_size(file)
            with ZipFile(file) as archive:
                yield ArrayArchive(path, archive, size)
        except Exception as error:
            if isinstance(error, InputError) and error.where == str(path):
                raise
            raise InputError(path, f"is no {what} of mrts, or damaged ({error}). {advice}") from None


def _checked_size(file: BinaryIO) -> int:
    """Size of an archive whose list of members ends it and is short: zipfile reads all of the list at once."""
    size = file.seek(0, os.SEEK_END)
    file.seek(max(size - END_BYTES - LOCATOR_BYTES, 0))
    tail = file.read()
    end = tail[-END_BYTES:]
    if not end.startswith(END_RECORD) or tail.startswith(END_64_LOCATOR) or end[-2:] != b"\0\0":
        raise ValueError("File is not a zip file")
    if int.from_bytes(end[12:16], "little") > DIRECTORY_BYTES:
        raise ValueError("it lists too many members")
    return size


def _array(content: bytes) -> NDArray[Any]:
    """An array from the text of a .npy file, if it is as large as it says."""
    stream = BytesIO(content)
    header = {(1, 0): read_array_header_1_0, (2, 0): read_array_header_2_0}[read_magic(stream)]
    shape, _, kind = header(stream)
    if not kind.hasobject and math.prod(shape) * kind.itemsize != len(content) - stream.tell():
        raise ValueError("an array is cut off")
    stream.seek(0)
    return np.asarray(read_array(stream, allow_pickle=False))

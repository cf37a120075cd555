# SPDX-License-Identifier: MIT
"""Names that a library may have: they prefix its symbols, and name its header and its target."""

import re

from mrts.base.errors import InputError
from mrts.base.input_file import IDENTIFIER, LONGEST_NAME

BUILD_NAMES = frozenset({"all", "c", "clean", "example", "help", "install", "m", "mrts", "package", "test"})
"""Names that a build system or the kernel uses itself."""

C_HEADERS = frozenset(
    {"assert", "complex", "ctype", "errno", "features", "fenv", "float", "inttypes", "limits", "locale", "math"}
    | {"setjmp", "signal", "stdarg", "stdatomic", "stdbool", "stddef", "stdint", "stdio", "stdlib", "string", "tgmath"}
    | {"threads", "time", "uchar", "wchar", "wctype"}
)
"""Headers of the C library, which a header of ours with that name would hide."""


def check_library_name(name: str) -> None:
    """Refuse a name that C or build systems do not take."""
    if not re.fullmatch(IDENTIFIER, name) or len(name) > LONGEST_NAME:
        raise InputError(
            "--name",
            f"must be letters, digits and single underscores, start with a letter, and have at most {LONGEST_NAME} "
            "characters.",
            value=name,
        )
    if name in BUILD_NAMES | C_HEADERS:
        raise InputError("--name", "is taken by build systems, the C library or the kernel; give another.", value=name)

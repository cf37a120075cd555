# SPDX-License-Identifier: MIT
"""The kernel's functions and structures as its C declares them."""

import ctypes
import re
from functools import cache
from typing import Any

import numpy as np

from mrts.kernel.c_text import one_text

NUMBERS: dict[str, Any] = {"int": ctypes.c_int, "long long": ctypes.c_longlong, "double": ctypes.c_double}
NUMBERS |= {"mrts_real": ctypes.c_double}

FUNCTION = re.compile(r"^MRTS_EXPORT (void|int|long long) (mrts_\w+)\(([^{};]*)\) \{", re.MULTILINE)


def _address(value: object) -> object:
    """A pointer as ctypes passes it on: to the first entry of an array, to a structure, to nothing, or as given."""
    if isinstance(value, np.ndarray):
        return ctypes.c_void_p(value.ctypes.data)
    return ctypes.byref(value) if isinstance(value, ctypes.Structure) else value


ADDRESS: Any = type("Address", (), {"from_param": staticmethod(_address)})
"""The type of parameters that are pointers."""


def bind(library: ctypes.CDLL, files: tuple[str, ...]) -> ctypes.CDLL:
    """Give the functions that files of mrts/kernel/c export to Python the types of their arguments and results.

    Raises:
        AttributeError: If it lacks a function.
    """
    for name, result, parameters in _declared(files):
        function = getattr(library, name)
        function.restype, function.argtypes = result, parameters
    return library


@cache
def _declared(files: tuple[str, ...]) -> list[tuple[str, Any, list[Any]]]:
    found = []
    for result, name, parameters in FUNCTION.findall(one_text(files)):
        given = [] if parameters == "void" else parameters.split(",")
        kinds = [ADDRESS if "*" in one else NUMBERS.get(" ".join(one.split()[:-1]), ADDRESS) for one in given]
        found.append((name, NUMBERS.get(result), kinds))
    return found


@cache
def structure(file: str, name: str) -> Any:
    """The class of a structure that a file of mrts/kernel/c defines or includes; pointers are addresses."""
    found = re.search(
        rf"typedef struct {{([^}}]*)}} {name};", re.sub(r"/\*.*?\*/", "", one_text((file,)), flags=re.DOTALL)
    )
    assert found is not None, name  # noqa: S101 (names of ours)
    fields: list[tuple[str, Any]] = []
    for declaration in found.group(1).split(";")[:-1]:
        kind, *declarators = re.split(r"\s(?=\**\w+(?:\[\d+\])?(?:,|$))", declaration.strip().removeprefix("const "))
        for declarator in declarators:
            stars, field, length = re.findall(r"(\**)(\w+)(?:\[(\d+)\])?", declarator)[0]
            of = ctypes.c_void_p if stars else NUMBERS.get(kind) or structure(file, kind)
            fields.append((field, of * int(length) if length else of))
    return type(name, (ctypes.Structure,), {"_fields_": fields})

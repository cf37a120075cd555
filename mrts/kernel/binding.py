# SPDX-License-Identifier: MIT
"""The kernel's functions and structures as its C declares them."""

import ctypes
import re
import threading
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.kernel.c_text import one_text

NUMBERS: dict[str, Any] = {"int": ctypes.c_int, "long long": ctypes.c_longlong, "double": ctypes.c_double}
NUMBERS |= {"short": ctypes.c_short, "float": ctypes.c_float, "cell_status": ctypes.c_int}
NUMBERS |= {"unsigned char": ctypes.c_ubyte, **dict.fromkeys(("mrts_real", "cell_real"), ctypes.c_double)}

FUNCTION = re.compile(
    r"\n(?:MRTS_EXPORT (void|int|long long)|(cell_real|cell_status)) ((?:mrts|cell)_\w+)\(([^{};]*)\) \{"
)


HEAD = object.__basicsize__
"""Bytes of an array object before the pointer to its numbers, which is the first thing in it (numpy/ndarraytypes.h):
`array.ctypes.data`, or a function for it, took a tenth of a short call."""


def _address(value: object) -> object:
    """A pointer as ctypes passes it on: to the first entry of an array, to a structure, to nothing, or as given."""
    if isinstance(value, np.ndarray):
        return ctypes.c_void_p.from_address(id(value) + HEAD)
    return ctypes.byref(value) if isinstance(value, ctypes.Structure) else value


ARRAYS = (np.ndarray, list)


def _given(kind: Any) -> Any:
    """The type of parameters that point at numbers that C reads: what is given is made an array of these."""
    of = np.dtype(kind)

    def read(value: object) -> object:
        if not isinstance(value, ARRAYS):
            return _address(value)
        array = np.ascontiguousarray(value, dtype=of)
        found: Any = ctypes.c_void_p.from_address(id(array) + HEAD)
        if array is not value:
            found.array = array
        return found

    return type("Given", (), {"from_param": staticmethod(read)})


ADDRESS: Any = type("Address", (), {"from_param": staticmethod(_address)})
"""The type of other parameters that are pointers."""

GIVEN: Any = {name: _given(kind) for name, kind in NUMBERS.items()}


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
    for ours, exported, name, parameters in FUNCTION.findall(one_text(files)):
        given = [] if parameters == "void" else parameters.split(",")
        kinds = []
        for one in given:
            constant, kind, pointer = re.findall(r"(const )?(\w[\w ]*?) (?=(\*|\w+\[)?)\S+$", one.strip())[0]
            kinds.append((GIVEN if constant and pointer else {} if pointer else NUMBERS).get(kind, ADDRESS))
        found.append((name, NUMBERS.get(ours or exported), kinds))
    return found


@cache
def structure(file: str, name: str, **sizes: int) -> Any:
    """The class of a structure that a file of mrts/kernel/c defines or includes; pointers are addresses.

    Sizes are those of arrays that C knows by macros. `arrays` of the class has the numbers that pointers point at.
    """
    found = re.search(rf"typedef struct {{([^}}]*)}} {name};", one_text((file,)))
    assert found is not None, name  # noqa: S101 (names of ours)
    fields, arrays = list[tuple[str, Any]](), dict[str, Any]()
    body = re.sub(r"/\*.*?\*/|^#.*?$", "", found.group(1), flags=re.DOTALL | re.MULTILINE)
    for declaration in body.split(";")[:-1]:
        kind, *declarators = re.split(r"\s(?=\**\w+(?:\[\w+\])*(?:,|$))", declaration.strip().removeprefix("const "))
        for declarator in declarators:
            stars, field, lengths = re.findall(r"(\**)(\w+)((?:\[\w+\])*)", declarator)[0]
            of = ctypes.c_void_p if stars else NUMBERS.get(kind) or structure(file, kind)
            for length in reversed(re.findall(r"\w+", lengths)):
                of *= int(length) if length.isdigit() else sizes[length]
            fields.append((field, of))
            if stars and kind in NUMBERS:
                arrays[field] = np.dtype(NUMBERS[kind])
    return type(name, (ctypes.Structure,), {"_fields_": fields, "arrays": arrays})


def filled(kind: Any, **values: Any) -> Any:
    """A structure of numbers, structures and arrays, made contiguous and of the C's numbers; it keeps them alive."""
    numbers, kept = dict(values), []
    for name, of in kind.arrays.items():
        if values.get(name) is not None:
            kept.append(np.ascontiguousarray(values[name], dtype=of))
            numbers[name] = ctypes.c_void_p.from_address(id(kept[-1]) + HEAD)
    made = kind(**numbers)
    made.kept = values, kept
    return made


INFINITY = 1e300
"""What an absent limit is in C, or its negative; `MRTS_INFINITY` of numbers.h."""

FREED = 1 << 24
"""Bytes of the block that is freed once. The system's C library keeps twice as many for later arrays."""


def keep_freed_memory() -> None:
    """Let memory that arrays give back serve the next ones: fresh pages cost as much as what is computed into them.

    glibc gives memory back to the system at once until a large block has been freed, then it keeps twice that size
    (mallopt(3), M_MMAP_THRESHOLD). Elsewhere nothing changes.
    """
    np.empty(FREED, dtype=np.uint8)  # nobody writes to it, so it takes no page


def work_arrays(library: ctypes.CDLL, function: str, *sizes: int) -> list[NDArray[Any]]:
    """The work arrays that a function of the kernel asks for by its `_work`, for some sizes: reals, and ints, zeros."""
    reals, ints = ctypes.c_longlong(), ctypes.c_longlong()
    getattr(library, f"{function}_work")(*sizes, ctypes.byref(reals), ctypes.byref(ints))
    return [np.empty(reals.value), np.zeros(ints.value, dtype=np.int32)]


def interruptible(call: Callable[[], int]) -> int:
    """What a foreign call returns, where Ctrl-C need not wait for it.

    Python runs handlers of signals between its own instructions, so a long call runs in a thread of its own, which an
    interrupt leaves behind: it may finish, in memory that it keeps.
    """
    returned: list[int] = []
    worker = threading.Thread(target=lambda: returned.append(call()), daemon=True)
    worker.start()
    worker.join()
    return returned[0]

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


ARRAYS = (np.ndarray, list)

POINTER = ctypes.c_void_p.from_address
"""`POINTER(id(array) + HEAD)` points to the numbers of an array that somebody keeps alive."""


def _caller(function: Any, result: Any, kinds: list[Any]) -> Callable[..., Any]:
    """A function of C by the kinds of its parameters; arrays and structures may be given for pointers.

    A kind is a number's type, the dtype of numbers that C reads, which what is given is made an array of, or None for
    other pointers.
    """
    function.restype = result
    function.argtypes = [ctypes.c_void_p if of is None or isinstance(of, np.dtype) else of for of in kinds]
    read = [(place, of) for place, of in enumerate(kinds) if isinstance(of, np.dtype)]

    def call(*given: Any) -> Any:
        kept = list(given)
        for place, of in read:
            if isinstance(kept[place], ARRAYS):
                kept[place] = np.ascontiguousarray(kept[place], dtype=of)
        return function(*[POINTER(id(value) + HEAD) if isinstance(value, np.ndarray) else value for value in kept])

    return call


def bind(library: ctypes.CDLL, files: tuple[str, ...]) -> ctypes.CDLL:
    """Give the functions that files of mrts/kernel/c export to Python the types of their arguments and results.

    Raises:
        AttributeError: If it lacks a function.
    """
    for name, result, parameters in _declared(files):
        setattr(library, name, _caller(library[name], result, parameters))
    return library


@cache
def _declared(files: tuple[str, ...]) -> list[tuple[str, Any, list[Any]]]:
    found = []
    for ours, exported, name, parameters in FUNCTION.findall(one_text(files)):
        given = [] if parameters == "void" else parameters.split(",")
        kinds = []
        for one in given:
            constant, kind, pointer = re.findall(r"(const )?(\w[\w ]*?) (?=(\*|\w+\[)?)\S+$", one.strip())[0]
            number = NUMBERS.get(kind)
            kinds.append(number if not pointer else np.dtype(number) if constant and number else None)
        found.append((name, NUMBERS.get(ours or exported), kinds))
    return found


AS_POINTER = {"_as_parameter_": property(ctypes.addressof)}
"""What makes structures pass for pointers to them."""


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
    return type(name, (ctypes.Structure,), {"_fields_": fields, "arrays": arrays, **AS_POINTER})


def filled(kind: Any, **values: Any) -> Any:
    """A structure of numbers, structures and arrays, made contiguous and of the C's numbers; it keeps them alive."""
    numbers, kept = dict(values), []
    for name, of in kind.arrays.items():
        if values.get(name) is not None:
            kept.append(np.ascontiguousarray(values[name], dtype=of))
            numbers[name] = POINTER(id(kept[-1]) + HEAD)
    made = kind(**numbers)
    made.kept = values, kept
    return made


INFINITY = 1e300
"""What an absent limit is in C, or its negative; `MRTS_INFINITY` of numbers.h."""


def keep_freed_memory() -> None:
    """Let memory that arrays give back serve the next ones: fresh pages cost as much as what is computed into them.

    glibc gives memory back to the system at once until a large block has been freed, then it keeps twice that size
    (mallopt(3), M_MMAP_THRESHOLD). Elsewhere nothing changes.
    """
    np.empty(1 << 24, dtype=np.uint8)  # nobody writes to it, so it takes no page


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

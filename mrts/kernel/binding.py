# SPDX-License-Identifier: MIT
"""The kernel's functions and structures as its C declares them."""

import ctypes
import re
import threading
from collections.abc import Callable
from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.kernel.c_text import one_text

NUMBERS: dict[str, Any] = {"int": ctypes.c_int, "long long": ctypes.c_longlong, "double": ctypes.c_double}
NUMBERS |= {"short": ctypes.c_short, "float": ctypes.c_float, "cell_status": ctypes.c_int}
NUMBERS |= dict.fromkeys(("mrts_real", "cell_real"), ctypes.c_double)

FUNCTION = re.compile(
    r"\n(?:MRTS_EXPORT (void|int|long long)|(cell_real|cell_status)) ((?:mrts|cell)_\w+)\(([^{};]*)\) \{"
)


HEAD = object.__basicsize__
"""Bytes of an array object before the pointer to its numbers, which is the first thing in it (numpy/ndarraytypes.h)."""


def address(array: NDArray[Any]) -> ctypes.c_void_p:
    """Where the numbers of an array lie, while it is there; `array.ctypes.data` took a tenth of a short call."""
    return ctypes.c_void_p.from_address(id(array) + HEAD)


def _address(value: object) -> object:
    """A pointer as ctypes passes it on: to the first entry of an array, to a structure, to nothing, or as given."""
    if isinstance(value, np.ndarray):
        return ctypes.c_void_p.from_address(id(value) + HEAD)  # `address`, whose call would cost as much
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
    for ours, exported, name, parameters in FUNCTION.findall(one_text(files)):
        given = [] if parameters == "void" else parameters.split(",")
        kinds = [ADDRESS if "*" in one else NUMBERS.get(" ".join(one.split()[:-1]), ADDRESS) for one in given]
        found.append((name, NUMBERS.get(ours or exported), kinds))
    return found


@cache
def structure(file: str, name: str, **sizes: int) -> Any:
    """The class of a structure that a file of mrts/kernel/c defines or includes; pointers are addresses.

    Sizes are those of arrays that C knows by macros.
    """
    found = re.search(rf"typedef struct {{([^}}]*)}} {name};", one_text((file,)))
    assert found is not None, name  # noqa: S101 (names of ours)
    fields: list[tuple[str, Any]] = []
    body = re.sub(r"/\*.*?\*/|^#.*?$", "", found.group(1), flags=re.DOTALL | re.MULTILINE)
    for declaration in body.split(";")[:-1]:
        kind, *declarators = re.split(r"\s(?=\**\w+(?:\[\w+\])*(?:,|$))", declaration.strip().removeprefix("const "))
        for declarator in declarators:
            stars, field, lengths = re.findall(r"(\**)(\w+)((?:\[\w+\])*)", declarator)[0]
            of = ctypes.c_void_p if stars else NUMBERS.get(kind) or structure(file, kind)
            for length in reversed(re.findall(r"\w+", lengths)):
                of *= int(length) if length.isdigit() else sizes[length]
            fields.append((field, of))
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def filled(kind: Any, **values: Any) -> Any:
    """A structure of numbers and of addresses of arrays, contiguous and of the C's types, which it keeps alive."""
    made = kind(**{name: address(of) if isinstance(of, np.ndarray) else of for name, of in values.items()})
    made.kept = values
    return made


INFINITY = 1e300
"""What an absent limit is in C, or its negative; `MRTS_INFINITY` of numbers.h."""

KNOWN_SIZES = 1024
"""Sizes of work arrays that are kept, of the libraries asked last: each call would ask C for its own again."""


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
    reals, ints = _work(library, function, sizes)
    return [np.empty(reals), np.zeros(ints, dtype=np.int32)]


@lru_cache(maxsize=KNOWN_SIZES)
def _work(library: ctypes.CDLL, function: str, sizes: tuple[int, ...]) -> tuple[int, int]:
    reals, ints = ctypes.c_longlong(), ctypes.c_longlong()
    getattr(library, f"{function}_work")(*sizes, ctypes.byref(reals), ctypes.byref(ints))
    return reals.value, ints.value


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

# SPDX-License-Identifier: MIT
"""Whether a cell's compiled functions are those that its manifest describes: C reads and writes where it is told to."""

import ctypes
from functools import lru_cache
from pathlib import Path

from mrts.base.errors import InputError
from mrts.base.manifest import LOAD_ENTRIES, ArgumentRecord, Manifest, geometry_size
from mrts.kernel.foreign_arrays import KNOWN_SIZES

Shapes = list[tuple[int, int]]

LARGEST_WORK = 10**7
"""Entries of a function's work array: generated ones have at most some thousands."""

ADVICE = "Make C file and manifest again: `mrts generate`."


def check_shapes(where: Path | str, manifest: Manifest, library: ctypes.CDLL) -> None:
    """Ask the library for the shapes of every function, and compare.

    Args:
        where: The manifest's file, or what else it is from, for messages.
        manifest: Manifest of the cell.
        library: The cell's library.

    Raises:
        InputError: If manifest, library and what the kernel takes for granted differ.
    """
    for name, (inputs, outputs) in _kernel_shapes(manifest).items():
        record = manifest.functions.get(name)
        if record is None:
            continue  # one for redundant arms, where there are none
        if (_shapes(record.inputs), _shapes(record.outputs)) != (inputs, outputs):
            raise InputError(
                where,
                f"its shapes do not follow from robots, joints and wrench components. {ADVICE}",
                key=f"functions.{name}",
            )
    for name, record in manifest.functions.items():
        try:
            same = _compiled_shapes(library, record.symbol, "in") == _shapes(record.inputs)
            same = same and _compiled_shapes(library, record.symbol, "out") == _shapes(record.outputs)
            work = work_sizes(library, record.symbol)
        except (AttributeError, ValueError):  # ValueError: a null pointer
            raise InputError(where, f"the C file holds no such function. {ADVICE}", key=f"functions.{name}") from None
        if not same or not all(0 <= size <= LARGEST_WORK for size in work):
            raise InputError(where, f"the compiled function has other shapes. {ADVICE}", key=f"functions.{name}")


@lru_cache(maxsize=KNOWN_SIZES)
def work_sizes(library: ctypes.CDLL, symbol: str) -> tuple[int, ...]:
    """Entries of the work arrays arg, res, iw and w that a generated function wants.

    Args:
        library: Holds it.
        symbol: Its name there.

    Raises:
        AttributeError: If the library holds no such function.
    """
    sizes = [ctypes.c_longlong() for _ in range(4)]
    getattr(library, f"{symbol}_work")(*(ctypes.byref(size) for size in sizes))
    return tuple(size.value for size in sizes)


def _kernel_shapes(manifest: Manifest) -> dict[str, tuple[Shapes, Shapes]]:
    """Inputs and outputs of the functions that the C of a cell calls, as it has them."""
    n, w = len(manifest.robots), len(manifest.wrench_components)
    m, f, k = sum(len(robot.joints) for robot in manifest.robots), n * w, (n - 1) * w + 1
    joints = (m, 1)
    held = sum(len(robot.held_numbers) for robot in manifest.robots)
    last = [] if manifest.is_baked else [(geometry_size(n, held), 1)]
    sample = [joints, joints, joints, (3, 3), (6, 1), (6, 1), (len(LOAD_ENTRIES), 1), *last]
    return {
        "wrench_form": (sample, [(m, k), (m, 1), (f, k), (f, 1)]),
        "kinematics": ([joints, *last], [(3, n), (3, 3 * n), (w, m)]),
        "bias_acceleration": ([joints, joints, *last], [(w, n)]),
        "geometric_stiffness": ([joints, (f, 1), *last], [(m, m)]),
        "geometric_stiffness_rate": ([joints, joints, (f, 1), *last], [(m, 1)]),
    }


def _shapes(arguments: list[ArgumentRecord]) -> Shapes:
    return [argument.shape for argument in arguments]


def _compiled_shapes(library: ctypes.CDLL, symbol: str, side: str) -> Shapes:
    """Shapes of all inputs ("in") or outputs ("out") of a generated function, as its C has them."""
    count, sparsity = library[f"{symbol}_n_{side}"], library[f"{symbol}_sparsity_{side}"]
    count.restype, sparsity.restype = ctypes.c_longlong, ctypes.POINTER(ctypes.c_longlong)
    found = [sparsity(ctypes.c_longlong(place)) for place in range(count())]
    return [(pattern[0], pattern[1]) for pattern in found]

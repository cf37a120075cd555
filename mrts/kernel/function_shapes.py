# SPDX-License-Identifier: MIT
"""Whether a cell's compiled functions are those that its manifest describes: C reads and writes where it is told to."""

import ctypes
from collections.abc import Iterable
from pathlib import Path

from mrts.base.errors import InputError
from mrts.base.manifest import LOAD_ENTRIES, ArgumentRecord, Manifest, geometry_size

Shapes = list[tuple[int, int]]

ADVICE = "Make C file and manifest again: `mrts generate`."


def check_shapes(where: Path | str, manifest: Manifest) -> None:
    """Compare what functions take and give with what the kernel takes for granted.

    Raises:
        InputError: If they differ.
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


def check_signatures(
    where: Path | str, manifest: Manifest, library: ctypes.CDLL, functions: Iterable[str]
) -> ctypes.CDLL:
    """A library, asked what functions take and give.

    Raises:
        InputError: If the manifest says otherwise.
    """
    for name in functions:
        record = manifest.functions[name]
        try:
            compiled = ctypes.c_char.in_dll(library, f"{record.symbol}_signature")
        except ValueError:
            raise InputError(where, f"the C file holds no such function. {ADVICE}", key=f"functions.{name}") from None
        if ctypes.string_at(ctypes.addressof(compiled)) != record.signature.encode():
            raise InputError(where, f"the compiled function has other shapes. {ADVICE}", key=f"functions.{name}")
    return library


def _kernel_shapes(manifest: Manifest) -> dict[str, tuple[Shapes, Shapes]]:
    n, w = len(manifest.robots), len(manifest.wrench_components)
    m, f, k = sum(len(robot.joints) for robot in manifest.robots), n * w, (n - 1) * w + 1
    joints = (m, 1)
    held = sum(len(robot.held_numbers) for robot in manifest.robots)
    last = [] if manifest.is_baked else [(geometry_size(n, held), 1)]
    sample = [joints, joints, joints, (3, 3), (6, 1), (6, 1), (len(LOAD_ENTRIES), 1)]
    return {
        "wrench_form": ([*sample, *last], [(m, k), (m, 1), (f, k), (f, 1)]),
        "fixed_distribution": ([*sample, (n, 1), (f, 1), *last], [(m, 1), (m, 1), (f, 1), (f, 1)]),
        "kinematics": ([joints, *last], [(3, n), (3, 3 * n), (w, m)]),
        "bias_acceleration": ([joints, joints, *last], [(w, n)]),
        "geometric_stiffness": ([joints, (f, 1), *last], [(m, m)]),
        "geometric_stiffness_rate": ([joints, joints, (f, 1), *last], [(m, 1)]),
    }


def _shapes(arguments: list[ArgumentRecord]) -> Shapes:
    return [argument.shape for argument in arguments]

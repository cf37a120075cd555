# SPDX-License-Identifier: MIT
"""The C of mrts/kernel/c: as one text to compile with a cell's generated C, or file by file for an export."""

import re
from functools import cache
from importlib.resources import files
from itertools import accumulate
from posixpath import dirname, join, normpath

from mrts.base.manifest import Manifest

PROGRAM_FILES = ("linear_programs.c", "quadratic_programs.c", "batch.c")
"""The programs, which need no cell."""

CELL_FILES = (
    *(*PROGRAM_FILES, "rows.c", "speed_intervals.c", "trajectory.c"),
    *(f"tracking/{name}.c" for name in ("null_space", "tracking", "quick_sample", "path")),
    *(f"variants/{name}.c" for name in ("follow", "end_rows", "ranges")),
)
"""All of the kernel; the last files need a cell's sizes and generated functions."""

SMOOTH_FILES = tuple(f"smooth/{name}.c" for name in ("smooth_rows", "smooth_second", "fronts", "interior_point"))
"""The programs of smooth timing, which need no cell either."""

INCLUDED = re.compile(r'^#include "((?:\.\./)?(?:\w+/)?\w+\.h)"\n', re.MULTILINE)


def one_file(name: str) -> str:
    """The text of a file in mrts/kernel/c, such as "linear_programs.c"."""
    return (files("mrts") / "kernel" / "c" / name).read_text(encoding="utf-8")


@cache
def one_text(names: tuple[str, ...]) -> str:
    """Some C files of the kernel, in order, as one text: each header of ours stands where it is first included.

    Args:
        names: Of files in mrts/kernel/c, such as "linear_programs.c", or "smooth/fronts.c".
    """
    taken: set[str] = set()

    def text(name: str) -> str:
        if name in taken:
            return ""
        taken.add(name)
        return INCLUDED.sub(lambda found: text(normpath(join(dirname(name), found.group(1)))), one_file(name))

    return "\n".join(text(name) for name in names)


def programs_source() -> str:
    """The C text of the library of programs."""
    return f"#define MRTS_LOCAL static\n{one_text(PROGRAM_FILES)}"


def smooth_source() -> str:
    """The C text of the library of smooth timing."""
    return f"#define MRTS_LOCAL static\n{one_text(SMOOTH_FILES)}"


def cell_source(manifest: Manifest, generated: str) -> str:
    """The C text of a cell's library: generated functions, sizes, the whole kernel."""
    symbol = {name: record.symbol for name, record in manifest.functions.items()}
    components, joints = len(manifest.wrench_components), [len(robot.joints) for robot in manifest.robots]
    first = list(accumulate(joints, initial=0))
    macros = {
        "MRTS_LOCAL": "static",
        "MRTS_JOINTS": first[-1],
        "MRTS_FIRST_JOINTS": f"{{{', '.join(map(str, first))}}}",
        "MRTS_MOST_JOINTS": max(joints),
        "MRTS_ROBOTS": len(manifest.robots),
        "MRTS_SIZE": components,
        "MRTS_WRENCHES": components * len(manifest.robots),
        "MRTS_INPUTS": len(manifest.functions["wrench_form"].inputs),
        "MRTS_UNKNOWNS": components * (len(manifest.robots) - 1) + 1,
        "MRTS_WRENCH_FORM": symbol["wrench_form"],
        "MRTS_KINEMATICS": symbol["kinematics"],
        "MRTS_BIAS_ACCELERATION": symbol["bias_acceleration"],
    }
    if max(joints) > components:
        macros["MRTS_REDUNDANT"] = 1
        macros["MRTS_GEOMETRIC_STIFFNESS"] = symbol["geometric_stiffness"]
        macros["MRTS_GEOMETRIC_STIFFNESS_RATE"] = symbol["geometric_stiffness_rate"]
    defined = "".join(f"#define {name} {value}\n" for name, value in macros.items())
    return f"{generated}\n{defined}{one_text(CELL_FILES)}"

# SPDX-License-Identifier: MIT
"""The C of mrts/kernel/c: as one text to compile with a cell's generated C, or file by file for an export."""

import re
from functools import cache
from itertools import accumulate
from pathlib import Path
from posixpath import dirname, join, normpath

from mrts.base.manifest import LOAD_ENTRIES, OF_MOTION, Manifest

BATCH, PROJECTIONS, SMOOTH = "batch.c", "projections.c", "smooth_timing.c"
"""Programs, which need no cell: each is a library of its own, compiled once for all cells."""

TRACKING = "tracking.c"
"""Inverse kinematics, which needs a cell's sizes and the functions of its motion."""

CELL_FILES = (BATCH, "trajectory.c", "widening.c", "arm_tips.c")
"""What needs a cell's sizes, and generated functions in lanes; with it batches, whose solvers these take too."""

SMOOTH_LEVEL = """#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("O2")
#endif
"""
"""Smooth timing takes a sixth longer with less, and is compiled once for all cells."""

SELDOM = ("dynamics", "terms", "torque_form", "fixed_distribution", "played_torques")
"""Generated functions that few calls take: each is compiled by itself when one does."""

IN_LANES = ("wrench_form", "kinematics", "bias_acceleration")
"""Generated functions that are compiled for lanes, the wrench form for these alone."""

INCLUDED = re.compile(r'^#include "((?:\.\./)?(?:\w+/)?\w+\.(?:h|inc|c))"\n', re.MULTILINE)

OVERRIDE = "exported/override_calls.c"
"""The governor of a plan's speed, as an exported library has it, and what Python asks of it besides."""

GENERATED = re.compile(r'^#include "cell(_model)?\.h"\n', re.MULTILINE)
"""Headers of an exported cell."""


def one_file(name: str) -> str:
    """The text of a file in mrts/kernel/c, such as "batch.c"."""
    return (Path(__file__).parent / "c" / name).read_text(encoding="utf-8")


@cache
def one_text(names: tuple[str, ...]) -> str:
    """Some C files of the kernel, such as "trajectory.c", in order, as one text: headers stand where first included.

    What is to be read more than once ends in .inc, and stands wherever it is included.
    """
    taken: set[str] = set()

    def text(name: str) -> str:
        if name in taken and name.endswith(".h"):
            return ""
        taken.add(name)
        ours = GENERATED.sub("", one_file(name)) if name.startswith("exported/") else one_file(name)
        return INCLUDED.sub(lambda found: text(normpath(join(dirname(name), found.group(1)))), ours)

    return "\n".join(text(name) for name in names)


def motion_macros(manifest: Manifest) -> dict[str, int | str]:
    """Sizes of a cell's arms and the generated functions of their motion."""
    symbol = {name: record.symbol for name, record in manifest.functions.items()}
    components, joints = len(manifest.cell.wrench_components), [len(robot.joints) for robot in manifest.cell.robots]
    first = list(accumulate(joints, initial=0))
    macros: dict[str, int | str] = {
        "MRTS_JOINTS": first[-1],
        "MRTS_FIRST_JOINTS": f"{{{', '.join(map(str, first))}}}",  # of each arm, and their number last
        "MRTS_MOST_JOINTS": max(joints),
        "MRTS_ROBOTS": len(manifest.cell.robots),
        "MRTS_SIZE": components,  # of a wrench
        "MRTS_KINEMATICS": symbol["kinematics"],
        "MRTS_BIAS_ACCELERATION": symbol["bias_acceleration"],
    }
    if {*joints} != {components}:
        macros["MRTS_UNEVEN"] = 1
    if max(joints) > components:
        macros["MRTS_REDUNDANT"] = 1
        macros["MRTS_GEOMETRIC_STIFFNESS"] = symbol["geometric_stiffness"]
        macros["MRTS_GEOMETRIC_STIFFNESS_RATE"] = symbol["geometric_stiffness_rate"]
    return macros


def cell_macros(manifest: Manifest) -> dict[str, int | str]:
    """Sizes of a cell and its generated functions."""
    components, arms = len(manifest.cell.wrench_components), len(manifest.cell.robots)
    sizes = [rows * columns for rows, columns in manifest.functions["wrench_form"].inputs.values()]
    return motion_macros(manifest) | {
        "MRTS_WRENCHES": components * arms,
        "MRTS_INPUTS": len(sizes),  # of the wrench form
        "MRTS_INPUT_SIZES": f"{{{', '.join(map(str, sizes))}}}",
        "MRTS_INPUT_NUMBERS": sum(sizes),
        "MRTS_GEOMETRY_NUMBERS": [*manifest.functions["kinematics"].inputs.values()][-1][0],
        "MRTS_UNKNOWNS": components * (arms - 1) + 1,  # wrenches of all arms but the last, and c²
        **{f"MRTS_{name.upper()}_LANES": f"{manifest.functions[name].symbol}_lanes" for name in IN_LANES},
    }


def _defined(macros: dict[str, int | str]) -> str:
    return "".join(f"#define {name} {value}\n" for name, value in macros.items())


def motion_source(manifest: Manifest, generated: str) -> str:
    """The C text of a library that follows: the functions of a cell's motion, sizes, inverse kinematics."""
    of_motion = function_source(manifest, generated, *(name for name in OF_MOTION if name in manifest.functions))
    return f"{of_motion}\n{_defined(motion_macros(manifest))}{one_text((TRACKING,))}"


def cell_source(manifest: Manifest, generated: str) -> str:
    """The C text of a cell's library: sizes, what of the kernel works in lanes, and generated functions for these."""
    _, functions = _functions(generated)
    in_lanes = "".join(functions.get(manifest.functions[name].symbol, "") for name in IN_LANES)
    of_lanes = one_file("lanes/model_of_lanes.inc") + in_lanes
    return f"{_defined(cell_macros(manifest))}{one_text(CELL_FILES)}\n{of_lanes}\n"


def function_source(manifest: Manifest, generated: str, *names: str) -> str:
    """The C text of a library of some generated functions."""
    head, functions = _functions(generated)
    return head + "".join(functions.get(manifest.functions[name].symbol, "") for name in names)


def override_source(manifest: Manifest, generated: str) -> str:
    """The C text of a library that plays a cell's plans: the exported one, and what Python calls."""
    components, record = len(manifest.cell.wrench_components), manifest.functions["played_torques"]
    macros: dict[str, int | str] = {
        "CELL_JOINTS": sum(len(robot.joints) for robot in manifest.cell.robots),
        "CELL_WRENCHES": components * len(manifest.cell.robots),
        "CELL_LOAD": len(LOAD_ENTRIES),
        "CELL_GEOMETRY": 1,
        "CELL_MOTORS": 1,
        "cell_model_played_torques": record.symbol,
    }
    return f"{function_source(manifest, generated, 'played_torques')}\n{_defined(macros)}{one_text((OVERRIDE,))}"


def _functions(generated: str) -> tuple[str, dict[str, str]]:
    """What stands before generated functions, and each by its symbol."""
    head, *functions = generated.split("\nMRTS_MODEL(")
    return head + "\n", {text.split(",", 1)[0]: f"MRTS_MODEL({text}\n" for text in functions}

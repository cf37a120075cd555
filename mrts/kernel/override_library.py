# SPDX-License-Identifier: MIT
"""The C that plays a plan at any speed, compiled for Python, and its structures of m joints and w wrench components."""

import ctypes
from typing import Any

import numpy as np

from mrts.base.manifest import LOAD_ENTRIES, Manifest
from mrts.kernel.binding import bind, structure
from mrts.kernel.c_text import OVERRIDE, override_source
from mrts.kernel.compiler import compiled_library


def override_library(manifest: Manifest, generated: str) -> ctypes.CDLL:
    """The functions of override_calls.c for a cell, compiled unless the cache holds them."""
    source = override_source(manifest, generated)
    return compiled_library("override", source, lambda path: bind(ctypes.CDLL(str(path)), (OVERRIDE,)))


def override_type(name: str, joints: int, wrenches: int) -> np.dtype[Any]:
    """A structure of the exported header: `cell_plan_node`, `cell_plan`, or `cell_override`, the state."""
    sizes = {"CELL_JOINTS": joints, "CELL_WRENCHES": wrenches, "CELL_LOAD": len(LOAD_ENTRIES)}
    made: np.dtype[Any] = np.dtype(structure("exported/cell_override.h", name, **sizes))
    return made

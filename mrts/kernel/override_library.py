# SPDX-License-Identifier: MIT
"""The C that plays a plan at any speed, compiled for Python, and its structures of m joints and w wrench components."""

import ctypes
from pathlib import Path
from typing import Any

import numpy as np

from mrts.base.manifest import LOAD_ENTRIES, Manifest
from mrts.kernel.binding import bind
from mrts.kernel.c_text import CALLS, override_source
from mrts.kernel.compiler import find_compiler, library_or_rebuilt


def override_library(manifest: Manifest, generated: str) -> ctypes.CDLL:
    """The functions of override_calls.c for a cell, compiled unless the cache holds them."""
    return library_or_rebuilt(find_compiler(), "override", override_source(manifest, generated), _bound)


def _bound(path: Path) -> ctypes.CDLL:
    return bind(ctypes.CDLL(str(path)), (f"{CALLS}.c",))


def node_type(joints: int, wrenches: int) -> np.dtype[Any]:
    """`cell_plan_node` of the exported header."""
    fields: list[Any] = [("time", "f8"), ("q", "f8", joints), ("dq", "f8", joints), ("ddq", "f8", joints)]
    fields += [("most", "f8"), ("acceleration", "f8", (2, 2)), ("rate", "f8", 2), ("rate_ahead", "f8")]
    fields += [("hold", "f8", (2, wrenches)), ("accelerate", "f8", (2, 2, wrenches)), ("active", "i2", 5)]
    return np.dtype(fields, align=True)


def state_type(joints: int, wrenches: int) -> np.dtype[Any]:
    """`cell_override` of the exported header."""
    fields: list[Any] = [("time", "f8"), ("speed", "f8"), ("acceleration", "f8")]
    fields += [(name, "f8", joints) for name in ("q", "dq", "ddq", "torque")]
    fields += [("wrench", "f8", wrenches), *((name, "i4") for name in ("active", "finished", "node", "direction"))]
    return np.dtype([*fields, ("inside", "f8"), ("aim", "f8")], align=True)


def plan_type(joints: int) -> np.dtype[Any]:
    """`cell_plan` of the exported header, with the geometry that exported functions hold as numbers."""
    fields: list[Any] = [("nodes", "u8"), *((name, "i4") for name in ("count", "backwards", "varies", "keeps_rates"))]
    fields += [("limits", "u8"), ("load", "f8", len(LOAD_ENTRIES))]
    fields += [(name, "f8", joints) for name in ("armature", "coulomb", "viscous")]
    return np.dtype([*fields, ("geometry", "u8")], align=True)

# SPDX-License-Identifier: MIT
"""Reading the mesh of an object: what is drawn of it, and the moments of the volume that it encloses."""

import hashlib
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.surface_text import MOST_DRAWN, coarser_surface, packed_surface
from mrts.base.input_file import LARGEST_NUMBER

FORMATS = ("stl", "obj", "ply", "off")
"""Endings of mesh files; those whose files may name others (dae, gltf) are left out: a mesh is one file."""

NO_VOLUME = 1e-9
"""Least volume of a body as a share of the cube around it: less is a sheet, or rounding."""


@dataclass(frozen=True)
class Mesh:
    """A mesh file as it was read.

    Attributes:
        path: The file, for messages.
        sha256: Of its bytes.
        vertices: Of the surface that is drawn, as text (`mrts.base.formats.surface_text`) [m].
        triangles: Three vertices each, as text.
        size: Longest side of the box around it [m].
        surface: As trimesh has it [m].
    """

    path: Path
    sha256: str
    vertices: str
    triangles: str
    size: float
    surface: Any

    def solid(self, advice: str) -> tuple[Array, Array]:
        """Centre of the enclosed volume, Shape (3,) [m], and its inertia about it for 1 kg, Shape (3, 3) [m²]."""
        if not self.surface.is_watertight:
            raise InputError(self.path, f"this mesh is not closed (watertight), so it encloses no volume. {advice}")
        if not self.surface.is_winding_consistent:
            rule = "the triangles of this mesh do not agree on which side is out, so its volume is not known."
            raise InputError(self.path, f"{rule} {advice}")
        with np.errstate(invalid="ignore", divide="ignore"):  # by a volume of 0
            moments = self.surface.mass_properties
        volume = float(moments.volume)
        if abs(volume) <= NO_VOLUME * self.size**3:
            raise InputError(self.path, f"this mesh encloses no volume. {advice}")
        return np.array(moments.center_mass), np.array(moments.inertia) / volume  # inside out: both change sign


def read_mesh(path: Path, content: bytes, scale: float) -> Mesh:
    """Read a mesh file."""
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise InputError(path, f"a mesh of an object is a file of {', '.join(FORMATS)}. Export it as one of them.")
    surface = _parsed(path, content, kind, scale)
    points, corners = np.asarray(surface.vertices, dtype=np.float64), np.asarray(surface.faces)
    if not len(corners) or not np.all(np.abs(points) <= LARGEST_NUMBER):
        raise InputError(path, "this mesh must have triangles, and vertices that are finite numbers.")
    size = float(np.max(np.ptp(points, axis=0)))
    if size <= 0:
        raise InputError(path, "all vertices of this mesh are one point.")
    vertices, triangles = packed_surface(*coarser_surface(points, corners, MOST_DRAWN))
    return Mesh(path, hashlib.sha256(content).hexdigest(), vertices, triangles, size, surface)


def _parsed(path: Path, content: bytes, kind: str, scale: float) -> Any:
    import trimesh  # noqa: PLC0415 (half a second, for cells that have a mesh)

    try:
        # from memory, without a resolver: an OBJ's materials, or whatever a file names, is not opened
        surface = trimesh.load_mesh(io.BytesIO(content), file_type=kind)
        scaled: Any = trimesh.Trimesh(surface.vertices * scale, surface.faces)
    except Exception as error:  # noqa: BLE001 (the readers of the formats raise what they like)
        raise InputError(path, f"cannot be read as a mesh ({type(error).__name__}: {error}).") from None
    return scaled

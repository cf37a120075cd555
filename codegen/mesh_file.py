# SPDX-License-Identifier: MIT
"""Reading the mesh of an object: what is drawn of it, and the moments of the volume that it encloses."""

import hashlib
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.surface_text import packed_surface
from mrts.base.input_file import LARGEST_NUMBER

FORMATS = ("stl", "obj", "ply", "off")
"""Endings of mesh files; those whose files may name others (dae, gltf) are left out: a mesh is one file."""

MOST_DRAWN = 2000
"""Triangles of a surface that is drawn; a finer mesh is drawn coarser."""

CELLS = 96
"""Of a coarser surface along its longest side, at first."""

NO_VOLUME = 1e-9
"""Least volume of a body as a share of the cube around it: less is a sheet, or rounding."""


@dataclass(frozen=True)
class Mesh:
    """A mesh file as it was read.

    Attributes:
        path: The file, for messages.
        sha256: Of its bytes.
        vertices: Of the surface that is drawn, as text (`mrts.base.formats.surface_text`) [m].
        triangles: Likewise.
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
        """Centre of the enclosed volume, Shape (3,) [m], and its inertia about it for 1 kg, Shape (3, 3) [m²].

        Args:
            advice: What to do where it encloses none; a sentence.

        Raises:
            InputError: If the surface is not closed, or its triangles do not agree on which side is out.
        """
        if not self.surface.is_watertight:
            raise InputError(self.path, f"this mesh is not closed (watertight), so it encloses no volume. {advice}")
        if not self.surface.is_winding_consistent:
            rule = "the triangles of this mesh do not agree on which side is out, so its volume is not known."
            raise InputError(self.path, f"{rule} {advice}")
        moments = self.surface.mass_properties
        volume = float(moments.volume)
        if abs(volume) <= NO_VOLUME * self.size**3:
            raise InputError(self.path, f"this mesh encloses no volume. {advice}")
        return np.array(moments.center_mass), np.array(moments.inertia) / volume  # inside out: both change sign


def read_mesh(path: Path, content: bytes, scale: float) -> Mesh:
    """Read a mesh file.

    Args:
        path: The file; its ending says its format.
        content: Its bytes.
        scale: Metres of one of its units.

    Raises:
        InputError: If it is of another format, damaged, or holds no triangle.
    """
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
    vertices, triangles = packed_surface(*drawn_surface(points, corners))
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


def drawn_surface(points: Array, corners: NDArray[np.integer[Any]]) -> tuple[Array, NDArray[np.integer[Any]]]:
    """A surface of few triangles that looks alike: vertices in one cell of a grid become one, their mean.

    Args:
        points: Vertices, Shape (V, 3) [m].
        corners: Triangles, Shape (T, 3).

    Returns:
        The surface itself where it has at most `MOST_DRAWN` triangles.
    """
    used, corners = np.unique(corners, return_inverse=True)
    points, corners = points[used], corners.reshape(-1, 3)
    longest, cells = float(np.max(np.ptp(points, axis=0))), CELLS
    coarse, few = points, corners
    while len(few) > MOST_DRAWN:
        places = np.floor((points - np.min(points, axis=0)) / longest * cells).astype(np.int64)
        _, group, size = np.unique(places, axis=0, return_inverse=True, return_counts=True)
        group = group.reshape(-1)
        coarse = np.stack([np.bincount(group, points[:, axis]) for axis in range(3)], axis=1) / size[:, None]
        few = group[corners]
        apart = (few[:, 0] != few[:, 1]) & (few[:, 1] != few[:, 2]) & (few[:, 2] != few[:, 0])
        _, first = np.unique(np.sort(few[apart], axis=1), axis=0, return_index=True)
        few = few[apart][first]
        cells = cells * 3 // 4
    return coarse, few

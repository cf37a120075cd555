# SPDX-License-Identifier: MIT
"""Triangles to pixels: what is nearest is seen, lit from above, and casts its shadow on the floor."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter

from mrts.base.arrays import Array
from mrts.film.camera import Camera
from mrts.film.solids import Index, Solid

AMBIENT, DIFFUSE, SHINE, SHARPNESS = 0.5, 0.6, 0.16, 24
"""How much light comes from everywhere and from the lamp, and how much of the lamp is mirrored how sharply."""

SHADOW = 0.3
"""How much darker the floor is in the shade."""

SOFT = 1 / 160
"""Radius of the shadow's blurred edge, as a share of the picture's width."""

NEAREST = 1e-3
"""What is nearer than this share of the picture's depth is behind the camera, or as good as."""

MOST_CANDIDATES = 4_000_000
"""Pixels that are looked at together: some hundred bytes each."""

Picture = NDArray[np.float32]
"""Shape (height, width, 3), 0 to 255."""


def drawn(background: Picture, camera: Camera, solids: Sequence[Solid], lamp: Array) -> Picture:
    """A picture of solids before a background.

    Args:
        background: As large as the camera's picture.
        camera: From where.
        solids: What.
        lamp: Unit vector towards the light, Shape (3,).
    """
    picture = background.copy()
    points, faces = _joined(solids)
    corners = camera.seen(points)[faces]
    triangle, pixel, weights = _nearest(corners, camera.size)
    normals = np.concatenate([solid.normals for solid in solids])
    colours = np.concatenate([np.tile(solid.colour, (len(solid.faces), 1)) for solid in solids])
    normal = np.einsum("pk,pki->pi", weights, normals[faces[triangle]])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    view = camera.rays(pixel)
    view /= np.linalg.norm(view, axis=1, keepdims=True)
    normal *= -np.sign(np.einsum("pi,pi->p", normal, view))[:, None]  # meshes do not always know their outside
    light = AMBIENT + DIFFUSE * np.maximum(normal @ lamp, 0)
    mirrored = view - 2 * np.einsum("pi,pi->p", normal, view)[:, None] * normal
    shine = 255 * SHINE * np.maximum(mirrored @ lamp, 0) ** SHARPNESS
    shaded = colours[triangle] * light[:, None] + shine[:, None]
    picture.reshape(-1, 3)[pixel] = np.minimum(shaded, 255)
    return picture


def shaded_floor(
    floor: Picture, camera: Camera, solids: Sequence[Solid], lamp: Array, plane: tuple[Array, Array]
) -> Picture:
    """A picture of the floor with the shadows of solids.

    Args:
        floor: Without them.
        camera: From where.
        solids: What is above the floor.
        lamp: Unit vector towards the light, Shape (3,).
        plane: Upward normal and a point of the floor.
    """
    up, point = plane
    casting = [solid for solid in solids if solid.casts]
    if not casting or lamp @ up <= 0:
        return floor
    points, faces = _joined(casting)
    height = (points - point) @ up
    fallen = points - height[:, None] / (lamp @ up) * lamp
    width, high = camera.size
    mask = np.zeros(width * high, dtype=np.uint8)
    corners = camera.seen(fallen)[faces[np.all(height[faces] > 0, axis=1)]]
    for _, pixel, _, _ in _candidates(corners, camera.size):
        mask[pixel] = 255
    shape = Image.fromarray(mask.reshape(high, width)).filter(ImageFilter.GaussianBlur(SOFT * width))
    shade = np.asarray(shape, dtype=np.float32)[:, :, None] / 255
    return np.asarray(floor * (1 - SHADOW * shade), dtype=np.float32)


def _joined(solids: Sequence[Solid]) -> tuple[Array, Index]:
    """Corners of all solids, and their triangles by place among these."""
    offsets = np.cumsum([0, *(len(solid.points) for solid in solids)])
    faces = [solid.faces + offset for solid, offset in zip(solids, offsets, strict=False)]
    return np.concatenate([solid.points for solid in solids]), np.concatenate(faces)


def _nearest(corners: Array, size: tuple[int, int]) -> tuple[Index, Index, Array]:
    """What is seen: triangle, pixel, and the shares of the triangle's corners."""
    depth = np.full(size[0] * size[1], np.inf)
    nothing = np.zeros(0, dtype=int), np.zeros(0, dtype=int), np.zeros(0), np.zeros((0, 3))
    found = [nothing, *_candidates(corners, size)]
    for _, pixel, away, _ in found:
        np.minimum.at(depth, pixel, away)
    triangles, pixels, shares = [], [], []
    for triangle, pixel, away, weights in found:
        seen = away == depth[pixel]
        triangles.append(triangle[seen])
        pixels.append(pixel[seen])
        shares.append(weights[seen])
    return np.concatenate(triangles), np.concatenate(pixels), np.concatenate(shares)


def _candidates(corners: Array, size: tuple[int, int]) -> Iterator[tuple[Index, Index, Array, Array]]:
    """Triangles and the pixels whose middles they cover, with distance and the shares of their corners.

    Triangles with boxes of about the same size are looked at together, each pixel of a box with all of them.

    Args:
        corners: In the picture, Shape (F, 3, 3).
        size: Of the picture.
    """
    width, height = size
    ahead = np.flatnonzero(np.all(corners[:, :, 2] > NEAREST * np.max(corners[:, :, 2], initial=0.0), axis=1))
    corners = corners[ahead]
    low = np.maximum(np.ceil(np.min(corners[:, :, :2], axis=1) - 0.5), 0).astype(int)
    high = np.minimum(np.floor(np.max(corners[:, :, :2], axis=1) - 0.5), [width - 1, height - 1]).astype(int)
    span = high - low + 1
    seen = np.flatnonzero(np.all(span > 0, axis=1))
    across, down = np.ceil(np.log2(span[seen])).astype(int).T
    kinds = 64 * across + down  # no picture has 2^64 pixels
    for kind in np.unique(kinds):
        members = seen[kinds == kind]
        columns, rows = np.max(span[members], axis=0).tolist()
        step = max(1, MOST_CANDIDATES // (columns * rows))
        for first in range(0, len(members), step):
            triangle, pixel, away, shares = _covered(corners, members[first : first + step], low, (columns, rows), size)
            yield ahead[triangle], pixel, away, shares


def _covered(
    corners: Array, members: Index, low: Index, box: tuple[int, int], size: tuple[int, int]
) -> tuple[Index, Index, Array, Array]:
    """Pixels of the boxes of some triangles that their triangle covers."""
    (width, height), (columns, rows) = size, box
    x = low[members, 0, None] + np.arange(columns)
    y = low[members, 1, None] + np.arange(rows)
    a, b, c = (corners[members, k] for k in range(3))
    whole = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    whole = np.where(whole == 0, np.nan, whole)  # seen edgewise it covers nothing

    def share(p: Array, q: Array) -> Array:
        """Of the corner across the edge from p to q, at the middle of every pixel."""
        across, down = (q[:, 0] - p[:, 0]) / whole, (q[:, 1] - p[:, 1]) / whole
        along_rows = across[:, None] * (y + 0.5 - p[:, 1, None])
        along_columns = down[:, None] * (x + 0.5 - p[:, 0, None])
        return np.asarray(along_rows[:, :, None] - along_columns[:, None, :])

    first, second = share(b, c), share(c, a)
    inside = (first >= 0) & (second >= 0) & (first + second <= 1)
    inside &= (x < width)[:, None, :] & (y < height)[:, :, None]
    which, row, column = np.nonzero(inside)
    first, second = first[inside], second[inside]
    # shares in the picture to shares in space: each divided by its corner's distance
    triangle = members[which]
    shares = np.column_stack([first, second, 1 - first - second]) / corners[triangle, :, 2]
    away = 1 / np.sum(shares, axis=1)
    pixel = (low[triangle, 1] + row) * width + low[triangle, 0] + column
    return triangle, pixel, away, shares * away[:, None]

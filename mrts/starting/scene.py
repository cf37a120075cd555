# SPDX-License-Identifier: MIT
"""What all arms of a cell that is begun share: which way is up, how large the box is, how far it goes."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.base.rigid_transform import plane_normal
from mrts.starting.arm import Arm
from mrts.starting.request import Request

WIDTH, LIFT, GRID = 0.3, 0.2, 0.12
"""Of the box, of the lift, and between heights that are tried, as shares of the shortest arm's reach."""


@dataclass(frozen=True, eq=False)
class Scene:
    """What all arms of a request share.

    Attributes:
        request: What is asked.
        up: World, Shape (3,).
        rows: Of a twist that count.
        width: Of the box [m].
        grid: Between places that are tried [m].
        lift: Shape (3,) [m].
        force: Of each hand on the object at rest, Shape (3,) [N].
    """

    request: Request
    up: Array
    rows: list[int]
    width: float
    grid: float
    lift: Array
    force: Array

    @property
    def arms(self) -> list[Arm]:
        """Of the request."""
        return [each.arm for each in self.request.arms]


def scene_of(request: Request, mass: float, share: float = 1.0) -> Scene:
    """The scene of a request.

    Args:
        request: What is asked.
        mass: Of the object [kg].
        share: Of the usual lift.
    """
    reach = min(each.arm.reach for each in request.arms)
    up = _up(request)
    force = -mass * request.gravity / len(request.arms)
    if request.plane is not None:
        force = force * (plane_normal(request.plane) == 0)
    lift = _nice(share * LIFT * reach) * up
    return Scene(
        request=request,
        up=up,
        rows=twist_rows(request.plane),
        width=_nice(WIDTH * reach),
        grid=_nice(GRID * reach),
        lift=lift,
        force=force,
    )


def twist_rows(plane: str | None) -> list[int]:
    """Components of a twist that count: all in space, in a plane the two along it and the turn about its normal."""
    if plane is None:
        return list(range(6))
    normal = np.abs(plane_normal(plane))
    return [*np.flatnonzero(normal == 0).tolist(), 3 + int(np.argmax(normal))]


def _up(request: Request) -> Array:
    """Against gravity, along an axis of the world; in the plane of a planar cell."""
    axes = np.eye(3)
    if request.plane is not None:
        axes = axes[np.abs(plane_normal(request.plane)) == 0]
    along = axes @ request.gravity
    best = int(np.argmax(np.abs(along)))
    if along[best] == 0:
        return np.asarray(axes[-1], dtype=np.float64)
    return np.asarray(-np.sign(along[best]) * axes[best] + 0.0, dtype=np.float64)


def _nice(length: float) -> float:
    """A length of two digits at most [m]."""
    step = 10.0 ** np.floor(np.log10(length)) / 2
    return float(np.round(max(np.round(length / step), 1) * step, 6))

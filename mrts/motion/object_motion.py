# SPDX-License-Identifier: MIT
"""The motion of the carried object: its samples, checked, and where it is known, its course between them."""

from collections.abc import Callable, Iterator
from dataclasses import InitVar, dataclass, field
from typing import Annotated, Any

import numpy as np

from mrts.base.arrays import Array, freeze
from mrts.base.errors import InputError, Remark
from mrts.base.formats.record import Shape, check_attributes
from mrts.base.notebook import InNotebooks, NotebookTable
from mrts.base.rigid_transform import vectors_from_rotations

ORTHOGONAL = 1e-6
"""Largest entry of R Rᵀ - I: matrices from tables carry few digits."""

RATE_TOLERANCE = 0.1
"""Largest part of a step that velocities may miss: a trapezoid in eleven samples misses 0.03."""

ACCELERATION_TOLERANCE = 0.5
"""The same for accelerations, which may jump inside a step; from the start to any sample the jumps cancel out."""

NOISE = 2e-4
"""Steps of positions and of rates that rounding may leave out [m, rad and per s]: tables may carry four decimals."""

NOISE_SHARE = 0.05
"""Share of the largest way, and of the largest rate, that it may be: else any table of a small motion passes."""

STILL = 1e-9
"""Steps that are rounding, whatever moves [m, rad and per s]."""

SHORTEST_STEP = 1e-9
"""Least time between samples [s]: below it squares of rates overflow."""

ObjectRates = tuple[Array, Array, Array, Array]
"""Position, rotation, twist and acceleration at some times, as in `ObjectMotion`."""

ObjectCourse = Callable[[Array], ObjectRates]
"""A motion of the object at any times from 0 to its end, Shape (k,) [s]."""


@dataclass(frozen=True, repr=False)
class ObjectMotion(InNotebooks):
    """N samples of the given motion of the object frame, world axes.

    Attributes:
        time: Shape (N,) [s], strictly increasing from 0.
        position: p, Shape (N, 3) [m].
        rotation: R_world_object, Shape (N, 3, 3).
        twist: [p'; φ'], Shape (N, 6) [m/s, rad/s].
        acceleration: [p''; φ''], Shape (N, 6) [m/s², rad/s²].
        remarks: What to know of how it was read.
        course: The same motion at any times; None where only its samples are known.

    Args:
        checked: False for one of this library's own making, whose arrays are taken as they are.
    """

    time: Annotated[Array, Shape("N", finite=True)]
    position: Annotated[Array, Shape("N", 3, finite=True)]
    rotation: Annotated[Array, Shape("N", 3, 3, finite=True)]
    twist: Annotated[Array, Shape("N", 6, finite=True)]
    acceleration: Annotated[Array, Shape("N", 6, finite=True)]
    remarks: tuple[Remark, ...] = field(default=(), kw_only=True)
    course: ObjectCourse | None = field(default=None, kw_only=True, compare=False)
    checked: InitVar[bool] = field(default=True, kw_only=True)

    def __repr__(self) -> str:
        return f"<ObjectMotion: {len(self.time)} samples in {self.time[-1]:.4g} s>"

    def notebook_tables(self) -> Iterator[NotebookTable]:
        """Where it begins and ends, how fast it is."""
        speed, turning = (np.max(np.linalg.norm(part, axis=1)) for part in np.split(self.twist, 2, axis=1))
        yield NotebookTable(("", ""), [
            ("duration", f"{self.time[-1]:.4g} s in {len(self.time)} samples"),
            ("from", f"{', '.join(f'{x:.6g}' for x in self.position[0])} m"),
            ("to", f"{', '.join(f'{x:.6g}' for x in self.position[-1])} m"),
            ("fastest", f"{speed:.4g} m/s, {turning:.4g} rad/s"),
            *((remark.code, remark.text) for remark in self.remarks),
        ])  # fmt: skip

    def __post_init__(self, checked: bool) -> None:
        if checked:
            check_attributes(self, ObjectMotion, "motion")
            if len(self.time) < 2 or self.time[0] != 0 or not np.all(np.diff(self.time) > 0):  # noqa: PLR2004 (two ends)
                raise InputError("time", "must have Shape (N,) with N >= 2, start at 0 and strictly increase.")
            if not _turns(self.rotation):
                raise InputError("rotation", "must hold rotation matrices: R Rᵀ = I, det R = 1.")
            self._check_rates()
        columns = np.ascontiguousarray(self.rotation.transpose(0, 2, 1))  # as generated functions read them
        columns.setflags(write=False)
        vars(self)["rotation"] = columns.transpose(0, 2, 1)
        freeze(self)

    def _check_rates(self) -> None:
        time = self.time
        steps = vectors_from_rotations(self.rotation[1:] @ self.rotation[:-1].transpose(0, 2, 1))
        turned = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
        noise = noise_allowed(np.column_stack([self.position, turned]), self.twist)
        check_derivatives("position", time, self.position, self.twist[:, :3], self.acceleration[:, :3], noise)
        check_derivatives("rotation", time, turned, self.twist[:, 3:], self.acceleration[:, 3:], noise)

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        freeze(self)


def _turns(rotation: Array) -> bool:
    rows = x, y, z = np.ascontiguousarray(rotation.transpose(1, 2, 0))
    off = np.einsum("ikn,jkn->ijn", rows, rows) - np.eye(3)[:, :, None]
    across = np.stack([x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]])
    return bool(max(np.max(off), -np.min(off)) <= ORTHOGONAL and np.min(np.einsum("kn,kn->n", across, z)) >= 0)


def noise_allowed(values: Array, rates: Array) -> tuple[float, float]:
    """What rounding may leave out of steps of all positions of a table, and of their derivatives, each Shape (N, k)."""
    way, rate = float(np.max(np.ptp(values, axis=0))), float(np.max(np.abs(rates)))
    return max(min(NOISE, NOISE_SHARE * way), STILL), max(min(NOISE, NOISE_SHARE * rate), STILL)


def check_derivatives(
    name: str, time: Array, value: Array, rate: Array, change: Array, noise: tuple[float, float]
) -> None:
    """Check rates against the way between samples: catches wrong units, axes and signs, and too few samples.

    From each sample to the next, and from the first to all others, where what cancels out within a few steps does not
    count. The rule that the way is compared with is of fourth order, so a reasonable table passes by far. Values, their
    rates and the changes of these are Shape (N, k).

    Raises:
        InputError: If the rates do not lead from sample to sample.
    """
    h = np.diff(time)[:, None]
    bend = h**2 / 12 * (change[:-1] - change[1:])
    for what, values, first, second, tolerance, left_out in (
        ("rates", value, rate, bend, RATE_TOLERANCE, noise[0]),
        ("accelerations", rate, change, 0.0, ACCELERATION_TOLERANCE, noise[1]),
    ):
        expected = h / 2 * (first[:-1] + first[1:]) + second
        steps, each = np.diff(values, axis=0), np.arange(len(h))
        jumps = 2 * float(np.max(_lengths(steps - expected))) if what == "accelerations" else 0.0
        for start, way, led, share, beside in (
            (each, steps, expected, tolerance, 0.0),
            (0 * each, values[1:] - values[0], np.cumsum(expected, axis=0), RATE_TOLERANCE, jumps),
        ):
            off, size = _lengths(way - led), max(float(np.max(_lengths(way))), float(np.max(_lengths(led))))
            worst = int(np.argmax(off))
            if off[worst] > share * size + beside + left_out:
                raise InputError(
                    name,
                    f"its {what} do not lead from sample {start[worst]} to {worst + 1} "
                    f"(t = {time[start[worst]]:.6g} to "
                    f"{time[worst + 1]:.6g} s): they are off by {100 * off[worst] / size:.3g} % of the largest such "
                    "step. Check units, world axes and signs; if those are right, the samples are too few, or have too "
                    "few digits.",
                )


def _lengths(steps: Array) -> Array:
    return np.asarray(np.linalg.norm(steps, axis=1), dtype=np.float64)

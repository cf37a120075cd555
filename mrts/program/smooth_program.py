# SPDX-License-Identifier: MIT
"""A path with rows whose values and rates of change are limited: what is solved for a smooth timing."""

from dataclasses import dataclass, field, replace
from itertools import compress
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array

OF_ROWS = ("square", "rate", "root", "offset", "lower", "upper", "change", "weight", "sizes")
"""Attributes whose last axis are the rows."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SmoothProgram:
    """Limits along a path σ with n nodes, on x = σ̇², u = σ̈ and free unknowns F (contact wrenches) at each of them.

    Between nodes u is linear in σ, so x_{k+1} = x_k + h_k (u_k + u_{k+1}) exactly. At node k row j has the value
    v = square x + rate u + root √x + free F + offset, and

        lower <= v_k <= upper                                           at every node
        √(zᵀ gram z) <= bound z with z = (u, x, 1)                      at every node, of each cone
        |v_{k+1} - v_k| <= change Δt_k                                  on every segment
        |q' (u_{k+1} - u_k) / h_k + 3 q'' u + q''' x| <= jerk / √x      at both ends of every segment

    with Δt_k = 2 h_k / (√x_k + √x_{k+1}). Rows are in units in which their limits have the size 1.

    Attributes:
        step: h, Shape (n - 1,).
        square: Shape (n, r).
        rate: Shape (n, r).
        root: Shape (n, r).
        offset: Shape (n, r).
        free: Shape (n, r, f); f may be 0.
        lower: -infinity where there is none, Shape (n, r).
        upper: infinity where there is none, Shape (n, r).
        change: Infinity where there is none, Shape (r,) [1/s].
        weight: Weight of v² in the effort ∫ τᵀWτ dt = Σ_k ω_k Σ_j weight v² / √x_k, with ω the trapezoidal rule,
            Shape (r,).
        sizes: What 100 % of the lower and of the upper side of each row is where its share counts in a reserve, 0
            where it does not, Shape (2, r).
        q1: q' of the joints whose jerk is limited, Shape (n, J).
        q2: q'' of them, Shape (n, J).
        q3: q''' of them at the start and at the end of every segment, Shape (n - 1, 2, J).
        jerk: Shape (J,).
        gram: Of c cones, Shape (n, c, 3, 3).
        bound: Of them, Shape (n, c, 3); the last of each is infinite at nodes without it.
        names: Names of the rows, and then of the cones.
        joints: Names of the joints whose jerk is limited.
        ends: x at the first and the last node where it is given, else None.
        end_free: F at the first and the last node, Shape (f,), where it is given, else None.
    """

    step: Array
    square: Array
    rate: Array
    root: Array
    offset: Array
    free: Array
    lower: Array
    upper: Array
    change: Array
    weight: Array
    sizes: Array
    q1: Array
    q2: Array
    q3: Array
    jerk: Array
    gram: Array = field(default_factory=lambda: np.zeros((1, 0, 3, 3)))
    bound: Array = field(default_factory=lambda: np.zeros((1, 0, 3)))
    names: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    ends: tuple[float | None, float | None] = (None, None)
    end_free: tuple[Array | None, Array | None] = (None, None)

    @property
    def nodes(self) -> int:
        """Number of nodes n."""
        return len(self.square)

    @property
    def spacing(self) -> Array:
        """ω of the trapezoidal rule over the nodes, Shape (n,)."""
        return np.concatenate([self.step[:1], self.step[:-1] + self.step[1:], self.step[-1:]]) / 2

    def narrowed(self, share: float) -> Self:
        """The same program with limits further in by a share, at most a quarter of what is between."""
        inward = np.minimum(share, (self.upper - self.lower) / 4)
        return replace(
            self,
            lower=self.lower + inward,
            upper=self.upper - inward,
            change=self.change * (1 - share),
            jerk=self.jerk * (1 - share),
            bound=self.bound - share * np.eye(3)[2],
        )

    def of_free(self) -> Self:
        """The same program with the rows alone that F moves: x and u keep the others and limits of jerk, or not."""
        nothing, q3 = np.zeros((self.nodes, 0)), np.zeros((self.nodes - 1, 2, 0))
        no_jerk: dict[str, Any] = {"q1": nothing, "q2": nothing, "q3": q3, "jerk": np.zeros(0), "joints": ()}
        return self.only(np.any(self.free, axis=(0, 2)), **no_jerk, gram=self.gram[:, :0], bound=self.bound[:, :0])

    def only(self, chosen: NDArray[np.bool_], **changes: Any) -> Self:
        """The same program with some of the rows, and other changes."""
        rows = np.flatnonzero(chosen)
        some: dict[str, Any] = {name: getattr(self, name)[..., rows] for name in OF_ROWS}
        names = *compress(self.names, chosen.tolist()), *self.names[len(chosen) :]  # those of the cones
        return replace(self, **some, free=self.free[:, rows], names=names, **changes)

    def values(self, x: Array, u: Array, free: Array) -> Array:
        """Values v of every row, Shape (n, r)."""
        moved = self.square * x[:, None] + self.rate * u[:, None] + self.root * np.sqrt(x)[:, None] + self.offset
        values: Array = moved + np.einsum("nrf,nf->nr", self.free, free)
        return values

    def times(self, x: Array) -> Array:
        """Δt of every segment, Shape (n - 1,) [s]; infinity where both ends stand still."""
        speed = np.sqrt(x)
        with np.errstate(divide="ignore"):
            times: Array = 2 * self.step / (speed[:-1] + speed[1:])
        return times

    def jerks(self, x: Array, u: Array) -> Array:
        """q⃛ at the start and at the end of every segment, Shape (n - 1, 2, J)."""
        segment = np.arange(len(self.step))
        ends = np.stack([segment, segment + 1], axis=1)
        slope, u, x = (np.diff(u) / self.step)[:, None, None], u[ends][..., None], x[ends][..., None]
        jerks: Array = (self.q1[ends] * slope + 3 * self.q2[ends] * u + self.q3 * x) * np.sqrt(x)
        return jerks

    def effort(self, x: Array, u: Array, free: Array) -> float:
        """Σ_k ω_k Σ_j weight v² / √x_k, ∫ τᵀWτ dt."""
        return float(np.sum(self.spacing / np.sqrt(x) * (self.values(x, u, free) ** 2 @ self.weight)))

    def beyond(self, x: Array, u: Array, free: Array) -> tuple[Array, Array, Array]:
        """By what share of a limit each is passed, below 0 where it is kept.

        Returns:
            Of rows and of cones at the nodes, Shape (n, r + c), infinitely little at nodes without a cone; of changes
            on the segments, Shape (n - 1, r), and of jerks, Shape (n - 1, J).
        """
        values, z = self.values(x, u, free), np.column_stack([u, x, np.ones(len(x))])
        square = np.einsum("ni,ncij,nj->nc", z, np.broadcast_to(self.gram, (len(x), *self.gram.shape[1:])), z)
        cones = np.sqrt(np.maximum(square, 0.0)) - np.sum(self.bound * z[:, None], axis=2)
        rows = np.concatenate([np.maximum(values - self.upper, self.lower - values), cones], axis=1)
        changes = np.abs(np.diff(values, axis=0)) / (self.change * self.times(x)[:, None]) - 1
        return rows, changes, np.max(np.abs(self.jerks(x, u)), axis=1) / self.jerk - 1

    def binding(self, x: Array, u: Array, free: Array, near: float) -> list[set[str]]:
        """Names of what is within a share `near` of its limit at an end of every segment or on it."""
        at, changing, jerking = (passed >= -near for passed in self.beyond(x, u, free))
        found: list[set[str]] = [set() for _ in self.step]
        for binds, what, names in (
            (at[:-1] | at[1:], "", self.names),
            (changing, "rate of ", self.names),
            (jerking, "jerk of ", self.joints),
        ):
            for segment, place in np.argwhere(binds).tolist():
                found[segment].add(what + names[place])
        return found

    def excess(self, x: Array, u: Array, free: Array) -> float:
        """The most by which a row, a change or a jerk passes its limit, as a share of it; <= 0 if all are kept."""
        return max(float(np.max(passed, initial=-1.0)) for passed in self.beyond(x, u, free))

    def keeps(self, profile: "SmoothProfile", tolerance: float) -> bool:
        """Whether a profile moves and passes no limit by more than a share of it."""
        return bool(np.all(profile.x > 0)) and self.excess(profile.x, profile.u, profile.free) <= tolerance

    def given_free(self) -> Array:
        """F that is given at the ends, else 0, Shape (n, f)."""
        free = np.zeros((self.nodes, self.free.shape[2]))
        for place, given in zip((0, -1), self.end_free, strict=True):
            if given is not None:
                free[place] = given
        return free


@dataclass(frozen=True)
class Goal:
    """What a timing is to be: the least of time · duration + effort · effort + uneven · Σ (Δu)² / h, within a duration.

    With a room it is one that takes by that share longer at most, with the least ∫ s² dt of `of_shares`.

    Attributes:
        time: Weight of the duration [1/s].
        effort: Weight of the effort; 0 leaves it out.
        longest: Largest duration, None for any [s].
        uneven: Weight of the jumps of u between nodes: without any, u may jump to and fro where x stands at a limit.
        room: Share of the least duration.
    """

    time: float = 1.0
    effort: float = 0.0
    longest: float | None = None
    uneven: float = 0.0
    room: float = 0.0


LEAST_EFFORT = Goal(time=0.0, effort=1.0)
"""Of the torques at a given timing, and of a timing within a duration."""


@dataclass(frozen=True)
class SmoothProfile:
    """x, u and F at n nodes.

    Attributes:
        x: σ̇², Shape (n,).
        u: σ̈, Shape (n,).
        free: Shape (n, f).
    """

    x: Array
    u: Array
    free: Array

# SPDX-License-Identifier: MIT
"""Which geometry the paper's seven values of c²⁺ themselves point to; used in docs/paper.md.

Three lengths and angles that the paper leaves out are searched for: the half-width w of the object, the height h of the
contacts above its centre of mass, and the world angle a of the last link (π - a for the right arm). What is made least
is the largest relative deviation of the seven values, six of which are independent: 6.2 is 6.1 (b) on another clock.

All geometries are evaluated at once: inverse kinematics in closed form, the generated terms of the shipped cell (which
hold for any grasp), linear programs on mrts's kernel. Last, what is found with the shipped identified cell.
"""

import sys
from dataclasses import dataclass

import numpy as np
from paper_readings import DATA, PAPER
from scipy.ndimage import minimum_filter
from scipy.optimize import linprog

import mrts
from mrts.base.arrays import Array
from mrts.commands.paper_examples import largest_c2, run_demo
from mrts.kernel.programs import INFEASIBLE, OPTIMAL, solve_batch

LINK, HAND = 1.0, 0.1  # m
GRAVITY = 9.8  # m/s²
MASS, HEAVY, LIGHT = 0.5, 3.0, 0.1  # kg
BASES = (0.0, 2.5)  # m
TORQUE = np.array([100.0, 80.0, 50.0] * 2)  # N m
WRENCH = np.array([2.0, np.inf, 1.0])  # N, N m
FASTER = (6 / 20) ** 2  # 6.2 plays the path of 6.1 on a clock that runs 20 / 6 times as fast
SEVEN = np.array([*PAPER[:3], 0.265, *PAPER[3:]])
FAR = 1e9  # stands for no limit
SAMPLES = slice(None, None, 10)  # of the lift's 101: in all these cells t = 0 binds, or nearly
CHUNK = 20_000
TRUST, SETTLED, STEP = 0.02, 1e-7, 1e-6  # of the refinement [m, rad]
APART, SHOWN = 0.02, 6
PROFILES = {
    "w, m": np.arange(1.06, 1.181, 0.01),
    "h, m": np.arange(-0.30, 0.01, 0.025),
    "a, rad": np.arange(-1.2, 1.21, 0.2),
}
NEARLY_STRAIGHT = 0.9999  # cosine of an elbow whose arm counts as out of reach


@dataclass(frozen=True)
class Elbows:
    """Signs of joint 2 of both arms."""

    left: float
    right: float


UP_UP, DOWN_UP = Elbows(-1, 1), Elbows(1, 1)


class Search:
    """Evaluates c²⁺ of the paper's examples for many geometries at once.

    Args:
        moments: Whether the moments r × f of the contact forces are kept in (4).
    """

    def __init__(self, *, moments: bool) -> None:
        self.moments = moments
        self.cell = mrts.load_cell(DATA / "planar_dual_arm" / "cell.yaml")
        lift = mrts.load_motion(DATA / "planar_dual_arm" / "lift.yaml")
        if not isinstance(lift, mrts.ObjectMotion):
            raise TypeError
        self.position, self.velocity = lift.position[SAMPLES, :2], lift.twist[SAMPLES, :2]
        self.acceleration = lift.acceleration[SAMPLES, :2]

    def deviations(self, geometry: Array) -> Array:
        """Relative deviations from `SEVEN`, Shape (N, 7), for w, h, a, Shape (N, 3); -1 where nothing is admissible."""
        parts = [self._deviations(geometry[start : start + CHUNK]) for start in range(0, len(geometry), CHUNK)]
        return np.concatenate(parts)

    def worst(self, geometry: Array) -> Array:
        """Largest deviation of any of the seven, Shape (N,)."""
        worst: Array = np.max(np.abs(self.deviations(geometry)), axis=1)
        return worst

    def _deviations(self, geometry: Array) -> Array:
        up, down = self._terms(geometry, UP_UP), self._terms(geometry, DOWN_UP)
        limited = self._free(geometry, up, MASS, WRENCH)
        heavy = np.minimum(self._free(geometry, up, HEAVY, WRENCH), self._free(geometry, up, LIGHT, WRENCH))
        values = [
            self._free(geometry, up, MASS, np.full(3, np.inf)),
            limited,
            self._even(up),
            FASTER * limited,
            self._free(geometry, down, MASS, WRENCH),
            self._even(down),
            heavy,
        ]
        return np.column_stack(values) / SEVEN - 1

    def _terms(self, geometry: Array, elbows: Elbows) -> tuple[Array, Array, Array, Array]:
        """E, G, Shape (N, K, 6), J, Shape (N, K, 3, 6), and whether both arms reach, Shape (N,)."""
        width, height, angle = geometry.T[:, :, None]
        q, reach = [], np.ones(len(geometry), dtype=bool)
        for base, side, elbow in ((BASES[0], -1, elbows.left), (BASES[1], 1, elbows.right)):
            turn = angle if side < 0 else np.pi - angle
            x = self.position[:, 0] + side * width - HAND * np.cos(turn) - base
            y = self.position[:, 1] + height - HAND * np.sin(turn)
            bend = (x**2 + y**2) / (2 * LINK**2) - 1
            reach &= np.all(np.abs(bend) < NEARLY_STRAIGHT, axis=1)
            q2 = elbow * np.arccos(np.clip(bend, -1, 1))
            q1 = np.arctan2(y, x) - q2 / 2
            q += [q1, q2, turn - q1 - q2]
        joints = np.stack(q, axis=-1)
        joints[~reach] = self.cell.robots[0].posture.tolist() * 2  # anything regular
        count, samples = joints.shape[:2]
        flat = joints.reshape(-1, 6)
        J = self.cell.functions("kinematics", len(flat), {"q": flat})["jacobian"].reshape(-1, 3, 2, 3)
        tip = np.zeros((count, samples, 3))
        tip[:, :, :2] = self.velocity
        dq = self._rates(J, tip)
        bias = self.cell.functions("bias_acceleration", len(flat), {"q": flat, "dq": dq})["bias_acceleration"]
        tip[:, :, :2] = self.acceleration
        ddq = self._rates(J, tip, bias)
        still = {
            "object_rotation": np.tile(np.eye(3), (len(flat), 1, 1)),
            "object_twist": np.zeros(6),
            "object_acceleration": np.zeros(6),
        }
        inputs = {"q": flat, "dq": dq, "ddq": ddq, "load": self.cell.load} | still
        terms = self.cell.functions("terms", len(flat), inputs)
        E, G = (terms[name].reshape(count, samples, 6) for name in ("E", "G"))
        return E, G, J.reshape(count, samples, 3, 6), reach

    @staticmethod
    def _rates(J: Array, tip: Array, bias: Array | None = None) -> Array:
        """Joint rates whose tips move as given, Shape (N K, 6)."""
        wanted = np.repeat(tip.reshape(-1, 3, 1), 2, axis=2)
        if bias is not None:
            wanted = wanted - bias.reshape(-1, 3, 2)
        rates = [np.linalg.solve(J[:, :, arm], wanted[:, :, arm : arm + 1])[:, :, 0] for arm in (0, 1)]
        return np.concatenate(rates, axis=1)

    def _even(self, terms: tuple[Array, Array, Array, Array]) -> Array:
        """(36) to (39) with half the load on each contact and no contact moment, Shape (N,)."""
        E, G, J, reach = terms
        half = np.stack([self.acceleration * MASS / 2, np.tile([0.0, MASS * GRAVITY / 2], (len(self.position), 1))])
        slope = E + np.einsum("nkwj,kw->nkj", J[:, :, :2], half[0])
        rest = G + np.einsum("nkwj,kw->nkj", J[:, :, :2], half[1])
        room = np.where(slope > 0, TORQUE - rest, -TORQUE - rest) / np.where(slope == 0, np.nan, slope)
        found: Array = np.nanmin(room, axis=(1, 2))
        return np.where(reach & np.all(np.abs(rest) <= TORQUE, axis=(1, 2)), found, 0.0)

    def _free(self, geometry: Array, terms: tuple[Array, Array, Array, Array], mass: float, wrench: Array) -> Array:
        """(26) to (30), the second wrench eliminated, Shape (N,)."""
        E, G, J, reach = terms
        count, samples = E.shape[:2]
        width, height = geometry[:, 0] * self.moments, geometry[:, 1] * self.moments
        # wrench of the right arm: of = constant + into (F_left, c²)
        into, of = np.zeros((count, samples, 3, 4)), np.zeros((count, samples, 3))
        into[:, :, 0, 0] = into[:, :, 1, 1] = into[:, :, 2, 2] = -1
        into[:, :, :2, 3] = mass * self.acceleration
        of[:, :, 1] = mass * GRAVITY
        # moments about the centre of mass: ν_l - w f_ly - h f_lx + ν_r + w f_ry - h f_rx = 0
        into[:, :, 2] += (height[:, None, None] * into[:, :, 0]) - width[:, None, None] * into[:, :, 1]
        into[:, :, 2, 0] += height[:, None]
        into[:, :, 2, 1] += width[:, None]
        of[:, :, 2] = height[:, None] * of[:, :, 0] - width[:, None] * of[:, :, 1]
        A = np.zeros((count, samples, 9, 4))
        A[:, :, :3, :3] = J[:, :, :, :3].transpose(0, 1, 3, 2)
        right = J[:, :, :, 3:].transpose(0, 1, 3, 2)
        A[:, :, 3:6] = right @ into
        A[:, :, :6, 3] += E
        A[:, :, 6:] = into
        offset = np.concatenate([G[:, :, :3], G[:, :, 3:] + (right @ of[..., None])[..., 0], of], axis=2)
        limit = np.concatenate([TORQUE, np.where(np.isfinite(wrench), wrench, FAR)])
        scale = np.concatenate([TORQUE, np.ones(3)])
        A, low, high = A / scale[:, None], (-limit - offset) / scale, (limit - offset) / scale
        bounds = np.where(np.isfinite(wrench), wrench, FAR)
        low = np.concatenate([low, np.broadcast_to([*-bounds, 0.0], (count, samples, 4))], axis=2)
        high = np.concatenate([high, np.broadcast_to([*bounds, FAR], (count, samples, 4))], axis=2)
        programs = count * samples
        g = np.tile([0.0, 0.0, 0.0, -1.0], (programs, 1))
        x, _, status = solve_batch(
            None, g, A.reshape(programs, 9, 4), low.reshape(programs, 13), high.reshape(programs, 13)
        )
        undecided = int(np.count_nonzero(~np.isin(status.reshape(count, samples)[reach], (OPTIMAL, INFEASIBLE))))
        if undecided:
            print(f"{undecided} programs undecided", file=sys.stderr)
        c2 = np.where(status == OPTIMAL, x[:, 3], 0.0).reshape(count, samples)
        return np.where(reach, np.min(c2, axis=1), 0.0)


def refined(search: Search, start: Array, free: tuple[int, ...] = (0, 1, 2)) -> tuple[Array, float]:
    """The best geometry near a start and its largest deviation, by linear programs in a trust region.

    Args:
        search: The evaluation.
        start: w, h, a.
        free: Which of them may move.
    """
    at, value = start, float(search.worst(start[None])[0])
    trust = TRUST
    while trust > SETTLED:
        steps = STEP * np.eye(3)[list(free)]
        around = search.deviations(np.vstack([at, at + steps, at - steps]))
        here, slopes = around[0], (around[1 : 1 + len(free)] - around[1 + len(free) :]).T / (2 * STEP)
        rows, ones = np.vstack([slopes, -slopes]), np.ones((2 * len(here), 1))
        bounds = [(-trust, trust)] * len(free) + [(0, None)]
        best = linprog([0] * len(free) + [1], np.hstack([rows, -ones]), np.concatenate([-here, here]), bounds=bounds)
        if best.x is None:
            break
        trial = at.copy()
        trial[list(free)] += best.x[:-1]
        reached = float(search.worst(trial[None])[0])
        if reached < value:
            at, value = trial, reached
        else:
            trust /= 2
    return at, value


def profile(search: Search, best: Array, index: int, values: Array) -> Array:
    """Least largest deviation with one of w, h, a held at each of some values and the others free."""
    found = np.empty(len(values))
    middle = int(np.argmin(np.abs(values - best[index])))
    others = tuple(other for other in range(3) if other != index)
    for way in (range(middle, len(values)), range(middle, -1, -1)):
        at = best
        for place in way:
            at = at.copy()
            at[index] = values[place]
            at, found[place] = refined(search, at, others)
    return found


def main() -> None:
    """Search, refine, and say how flat and how unique the best geometry is."""
    axes = np.arange(0.05, 1.3, 0.05), np.arange(-0.6, 0.61, 0.06), np.arange(-3.0, 3.2, 0.15)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    print(
        f"searched: w {axes[0][0]:.2f} … {axes[0][-1]:.2f} m, h {axes[1][0]:.2f} … {axes[1][-1]:.2f} m, every angle a"
    )
    for moments in (True, False):
        search = Search(moments=moments)
        worst = search.worst(grid.reshape(-1, 3)).reshape(grid.shape[:3])
        lowest = (worst == minimum_filter(worst, size=3, mode=("nearest", "nearest", "wrap"))) & (worst < 1)
        starts = grid[lowest][np.argsort(worst[lowest])]
        ends = sorted((refined(search, start) for start in starts), key=lambda end: end[1])
        print(f"\nr × f {'kept' if moments else 'left out'}: {len(starts)} minima of the grid, refined:")
        seen: list[Array] = []
        for at, value in ends:
            if all(np.max(np.abs(at - other)) > APART for other in seen) and len(seen) < SHOWN:
                seen.append(at)
                print(f"  w {at[0]:.4f} m, h {at[1]:+.4f} m, a {at[2]:+.4f} rad: largest deviation {100 * value:.2f} %")
        best = ends[0][0]
        print("  deviations of the best: " + ", ".join(f"{100 * d:+.2f} %" for d in search.deviations(best[None])[0]))
        for index, (name, values) in enumerate(PROFILES.items()):
            found = profile(search, best, index, values)
            print(f"  {name:<8}" + "".join(f"{value:>8.3f}" for value in values))
            print(f"  {'worst, %':<8}" + "".join(f"{100 * value:>8.2f}" for value in found))
    print("\nthe shipped identified cell, by mrts.scale at every sample:")
    found = run_demo(cell="identified_cell")
    print(", ".join(f"{case.id}: {100 * (largest_c2(result) / case.paper - 1):+.2f} %" for case, result in found))


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: MIT
"""One sparse nonlinear program: the layout, the joints and wrenches of all samples, and c²."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.null_space import is_redundant
from mrts.layout.grasp_equations import ObjectSymbols, grasp_equations, object_columns
from mrts.layout.layout_numbers import LayoutNumbers
from mrts.layout.limit_equations import LimitEquations
from mrts.layout.redundant_equations import multipliers, preference, redundant_joints
from mrts.layout.sample_equations import SharedSymbols, sample_equations

IPOPT_TOLERANCE = 1e-8
"""Of the scaled program: c² is then right to more digits than are printed."""

ITERATIONS = 300
"""Most iterations of IPOPT; some ten to thirty are usual."""

IPOPT_OPTIONS: dict[str, Any] = {
    "print_time": False,
    "error_on_fail": False,
    "calc_lam_p": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": IPOPT_TOLERANCE,
    "ipopt.max_iter": ITERATIONS,
    "ipopt.mu_strategy": "adaptive",
    # by default IPOPT oversteps bounds by 1e-8 of their size
    "ipopt.bound_relax_factor": 0.0,
}


@dataclass(frozen=True)
class LayoutAnswer:
    """What IPOPT found.

    Attributes:
        layout: Values of the numbers, Shape (P,).
        c2: c²⁺ there, of the samples of the program.
        slope: ∂ ln c²⁺/∂θ there, from the multipliers, Shape (P,): zero at a maximum inside the bounds.
        start: Joint positions at the program's first sample, Shape (m,) [rad or m].
        solved: Whether it is a local optimum.
    """

    layout: Array
    c2: float
    slope: Array
    start: Array
    solved: bool


@dataclass(frozen=True, kw_only=True)
class LayoutStart:
    """A layout that a cell can play, along the samples of a program.

    Attributes:
        cell: The cell in that layout.
        layout: Values of the numbers, Shape (P,).
        motion: Its motion.
        wrench: Wrenches that carry the load within all limits, Shape (N, n w) [N, N m].
        c2: At this c².
        loads: Load vectors, all of which must be carried, Shape (10,) each.
    """

    cell: Cell
    layout: Array
    motion: CoordinatedMotion
    wrench: Array
    c2: float
    loads: tuple[Array, ...]


class LayoutProgram:
    """Largest c² over layout θ, q_k, q'_k, q''_k and F_k of N samples, by IPOPT (Wächter and Biegler, 2006).

    Grasp closure and its two derivatives hold at each sample, and so do the rows of all limits, for every load. Balance
    of the object is kept by eliminating the last arm's wrench. Derivatives are CasADi's, of the expressions that the
    generated C is made of.

    Args:
        functions: CasADi's functions of the cell.
        numbers: The numbers of the layout.
        start: What to start from; says which chains, limits and loads.
        samples: Indices of its motion's samples, N of them.
    """

    def __init__(
        self, functions: dict[str, Any], numbers: LayoutNumbers, start: LayoutStart, samples: NDArray[np.intp]
    ) -> None:
        self.numbers, self.start, self.samples = numbers, start, samples
        cell, motion = start.cell, start.motion.at(samples)
        limits = LimitEquations.of(cell, motion)
        self.redundant = redundant_joints(cell)
        self.multipliers = multipliers(cell, start.motion.q, start.motion.q[0])
        shared = SharedSymbols.fresh(len(numbers.lower), len(self.redundant), self.multipliers.shape[1])
        geometry = numbers.geometry(cell, shared.layout)
        sample = sample_equations(cell, functions, geometry, shared, limits, start.loads)
        carried = motion.object
        given = object_columns(carried.position, carried.rotation, carried.twist, carried.acceleration)
        given = np.concatenate([given, limits.columns])
        count = len(samples)
        unknowns, ours = ca.MX.sym("unknowns", sample.unknowns, count), ca.MX.sym("shared", shared.stacked.numel())
        rows = sample.function.map("samples", "serial", count, [1], [])(unknowns, ours, ca.DM(given))
        begin = self._start_equations(functions, shared, geometry)
        self.program = {
            "x": ca.vertcat(ours, ca.vec(unknowns)),
            "f": -ours[shared.layout.numel()],
            "g": ca.vertcat(begin(ours), ca.vec(rows)),
        }
        held = np.zeros((count, sample.equations))
        repeated = [limits.rows.of_forces] * (len(start.loads) - 1)
        self.row_bounds = [
            np.concatenate([held, bound, *(bound[:, of_forces] for of_forces in repeated)], axis=1).ravel()
            for bound in limits.bounds
        ]
        self.row_bounds = [np.append(np.zeros(begin.numel_out()), bound) for bound in self.row_bounds]
        self.position_bounds = [
            np.concatenate([getattr(robot, f"position_{side}") for robot in cell.robots]) for side in ("lower", "upper")
        ]
        self.sample_unknowns = sample.unknowns

    def _start_equations(self, functions: dict[str, Any], shared: SharedSymbols, geometry: Any) -> Any:
        """What holds redundant arms at the start of the motion, nearest to their postures; nothing for others."""
        cell, first = self.start.cell, self.start.motion.object
        if not self.redundant:
            return ca.Function("start", [shared.stacked], [ca.SX(0, 1)])
        q = ca.SX(self.start.motion.q[0])
        q[self.redundant] = shared.reference
        at = ObjectSymbols(*(getattr(first, name)[0] for name in ("position", "rotation", "twist", "acceleration")))
        lower, upper = (
            np.concatenate([getattr(robot, f"position_{side}") for robot in cell.robots]) for side in ("lower", "upper")
        )
        closure = grasp_equations(cell, functions, (q, q, q), at, geometry)[0]
        w = len(cell.wrench_components)
        arms = [index for index, robot in enumerate(cell.robots) if is_redundant(cell, robot)]
        closure = ca.vertcat(*(closure[w * index : w * index + w] for index in arms))
        inside = ca.fmin(ca.fmax(self.numbers.postures(cell, shared.layout), lower), upper)
        nearest = preference(cell, functions, q, shared.multiplier, inside[self.redundant], geometry)
        return ca.Function("start", [shared.stacked], [ca.vertcat(closure, nearest)])

    def solve(
        self, bounds: tuple[Array, Array] | None = None, stop: Callable[[], bool] = lambda: False
    ) -> LayoutAnswer:
        """Search from the start.

        Args:
            bounds: Of the numbers, Shape (P,) each; None takes their own. Where both are equal, the number stays.
            stop: Asked at every iteration whether the search is to end.
        """
        lower, upper = bounds or (self.numbers.lower, self.numbers.upper)
        watch = _Watch(self.program["x"].numel(), self.program["g"].numel(), stop)
        solver = ca.nlpsol("layout", "ipopt", self.program, IPOPT_OPTIONS | {"iteration_callback": watch})
        free = [np.full(self.sample_unknowns, side * np.inf) for side in (-1, 1)]
        for values, limits in zip(free, self.position_bounds, strict=True):
            values[: len(limits)] = limits
        others = self.program["x"].numel() - len(lower) - self.sample_unknowns * len(self.samples)
        unlimited = np.full(others, np.inf)
        found = solver(
            x0=self._start(),
            lbx=np.concatenate([lower, -unlimited, np.tile(free[0], len(self.samples))]),
            ubx=np.concatenate([upper, unlimited, np.tile(free[1], len(self.samples))]),
            lbg=self.row_bounds[0],
            ubg=self.row_bounds[1],
        )
        P, joints = len(lower), len(self.position_bounds[0])
        x = found["x"].full()[:, 0]
        at = P + others
        jacobian = solver.get_function("nlp_jac_g")(x=x)["jac_g_x"][:, :P]
        slope = -(jacobian.T @ found["lam_g"]).full()[:, 0]
        return LayoutAnswer(
            layout=np.clip(x[:P], lower, upper),
            c2=float(np.exp(x[P])),
            slope=slope,
            start=x[at : at + joints],
            solved=bool(solver.stats()["success"]),
        )

    def _start(self) -> Array:
        start, at = self.start, self.samples
        motion, posture = start.motion, np.concatenate([robot.posture for robot in start.cell.robots])
        free = start.wrench[at, : -len(start.cell.wrench_components)]
        rates = np.zeros((len(at), 2 * self.multipliers.shape[1]))
        unknowns = [
            motion.q[at],
            motion.dq[at],
            motion.ddq[at],
            *[free] * len(start.loads),
            self.multipliers[at],
            rates,
        ]
        begin = [motion.q[0, self.redundant], multipliers(start.cell, motion.q[:1], posture)[0]]
        shared = [start.layout, [np.log(start.c2)], *begin]
        return np.concatenate([*shared, np.concatenate(unknowns, axis=1).ravel()])


class _Watch(ca.Callback):
    """Tells IPOPT at every iteration whether to stop.

    Args:
        unknowns: Number of unknowns.
        rows: Number of rows.
        stop: Asked.
    """

    def __init__(self, unknowns: int, rows: int, stop: Callable[[], bool]) -> None:
        ca.Callback.__init__(self)
        sizes = {"x": unknowns, "f": 1, "g": rows, "lam_x": unknowns, "lam_g": rows, "lam_p": 0}
        self.sizes = [sizes[ca.nlpsol_out(index)] for index in range(ca.nlpsol_n_out())]
        self.stop = stop
        self.construct("watch", {})

    def get_n_in(self) -> int:
        return len(self.sizes)

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, index: int) -> Any:
        return ca.Sparsity.dense(self.sizes[index], 1 if self.sizes[index] else 0)

    def eval(self, _arguments: Any) -> list[int]:
        return [int(self.stop())]

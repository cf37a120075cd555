# SPDX-License-Identifier: MIT
"""The kernel alone against DAQP on the same linear programs, C time, along the path (warm) and in random order.

DAQP's time is the `solve_time` that it reports for itself, of a new solve each and of one model that is updated: its
set-up, its update and Python are left out on purpose. Linear programs take its `eps_prox`. Ours is a whole batch,
scaling checks and certificates included.
"""

import statistics
import sys
import time
from pathlib import Path

import daqp
import numpy as np

from mrts.base.arrays import Array
from mrts.kernel.programs import solve_batch
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import UNBOUNDED
from mrts.program.solvers import ConvexPrograms

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cases import shipped
from interleaved import on_one_processor, show

SAMPLES, REPEATS = 1000, 7
SOLVED = 1


def daqp_times(g: Array, A: Array, lower: Array, upper: Array) -> tuple[list[float], list[float]]:
    """DAQP's own solve times of the programs that it solves: each by itself, and by one model that is updated [s]."""
    count, rows, k = A.shape
    H, sense = np.zeros((k, k)), np.zeros(rows + k, dtype=np.int32)
    # simple bounds come first there
    high, low = (np.clip(np.hstack([part[:, rows:], part[:, :rows]]), -1e30, 1e30) for part in (upper, lower))
    cold, warm = [], []
    model = daqp.Model()
    for n in range(count):
        _, _, flag, info = daqp.solve(H, g[n], A[n], high[n], low[n], sense, eps_prox=-1)
        if flag == SOLVED:
            cold.append(info["solve_time"])
        if n == 0:
            model.setup(H, g[n], A[n], high[n], low[n], sense)
            model.settings = {"eps_prox": -1}
        else:
            model.update(f=g[n], A=A[n], bupper=high[n], blower=low[n])
        _, _, flag, info = model.solve()
        if flag == SOLVED:
            warm.append(info["solve_time"])
    return cold, warm


def main(samples: int = SAMPLES, repeats: int = REPEATS) -> None:
    """Print both ends of the range, in both orders."""
    problem = build_sample_problem(motion_rows(*shipped("dual_ur5", samples)))
    count, _, k = problem.A.shape
    g = np.zeros((count, k))
    low, high = np.full((count, k), -np.inf), np.full((count, k), np.inf)
    low[:, -1], high[:, -1] = 0, UNBOUNDED
    for name, direction in (("least c²", 1.0), ("largest c²", -1.0)):
        g[:, -1] = direction
        effect = np.max(np.abs(problem.A[:, :, -1]), axis=1)
        A = problem.A.copy()
        A[:, :, -1] /= np.where(effect > 0, effect, 1)[:, None]
        ends = np.hstack([problem.lower, low]), np.hstack([problem.upper, high])
        scaled, _, _ = ConvexPrograms(None, g, A, *ends).scaled()
        lower, upper = scaled.lower, scaled.upper
        along, anyhow = np.arange(count), np.random.default_rng(0).permutation(count)
        for order_name, order in (("along the path", along), ("in random order", anyhow)):
            given = [np.ascontiguousarray(part[order]) for part in (scaled.g, scaled.A, lower, upper)]
            ours, cold, warm = [], [], []
            for _ in range(repeats):
                solve_batch(None, *given)  # each of DAQP's programs too is at hand in the processor when it is solved
                start = time.process_time()
                solve_batch(None, *given)
                ours.append((time.process_time() - start) / count)
                alone, updated = daqp_times(*given)
                cold += alone
                warm += updated
            taken = {"mrts, kernel": ours, "DAQP, a new solve each": cold, "DAQP, one model updated": warm}
            solved = {label: f"{len(taken[label]) // repeats} of {count} solved" for label in list(taken)[1:]}
            print(f"linear programs of the dual UR5-class cell, {name}, {order_name}")
            show({label: statistics.median(times) for label, times in taken.items()}, 1, "program", solved)


if __name__ == "__main__":
    on_one_processor()
    main()

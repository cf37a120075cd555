"""Tables of studies as a sweep writes them, with answers that are known beforehand."""

import numpy as np
import pyarrow as pa

from mrts.plots.study_plots import study_table

ELBOW, FORCE = "right/elbow ↑", "left/fx ↓"

AWKWARD = "robots.<img src=x onerror=window.broken=1>$x$.of a long, long, long, long name"


def found_study(values, duration, *, paths=None, planned=None, status=None, limit=ELBOW, reason="no way"):
    """A study as pictures take it; variants without a duration are infeasible where no status is given."""
    none = ~np.isfinite(duration)
    titles = {name: f"{name} [m]" for name in paths or [f"knob {number}" for number in range(values.shape[1])]}
    columns = {"variant": pa.array(np.arange(len(values)))}
    columns |= {name: pa.array(column) for name, column in zip(titles, values.T, strict=True)}
    status = np.where(none, "infeasible", "feasible") if status is None else status
    for name, texts, missing in (("status", status, 0), ("reason", reason, ~none), ("upper_limit", limit, none)):
        of_all = np.broadcast_to(np.asarray(texts, dtype=object), len(values))
        columns[name] = pa.array(list(np.where(missing, None, of_all)), pa.string())
    columns["c2_upper"] = pa.array((0.8 / np.where(none, 1, duration)) ** 2, mask=none)
    columns["duration"] = pa.array(np.where(none, 0, duration), mask=none)
    return study_table(pa.table(columns), "made_up", titles, planned or len(values))


def grid_study(across=12, up=9, **texts):
    """A grid over two numbers: a valley of durations, unreachable on its left, infeasible in a corner."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(0, 1, across), np.linspace(2, 3, up), indexing="ij"))
    duration = 0.3 + 0.5 * (x - 0.6) ** 2 + 0.2 * (y - 2)
    status = np.where(x < 0.2, "unreachable", np.where(x + y > 3.7, "infeasible", "feasible"))
    duration = np.where(status == "feasible", duration, np.nan)
    limit = np.where(x < 0.5, ELBOW, FORCE)
    return found_study(np.stack([x, y], axis=1), duration, status=status, limit=limit, **texts)


def drawn_study(count, numbers, seed=0, **texts):
    """Points drawn by chance over several numbers, of which the first two matter; some cannot be played."""
    rng = np.random.default_rng(seed)
    values = rng.uniform(0, 1, (count, numbers))
    second = values[:, min(1, numbers - 1)]
    duration = 0.3 + 0.5 * (values[:, 0] - 0.6) ** 2 + 0.2 * second + 0.01 * values[:, -1]
    duration = np.where(values[:, 0] < 0.15, np.nan, duration)
    return found_study(values, duration, limit=np.where(second < 0.5, ELBOW, FORCE), **texts)


def kinds():
    """Studies of every kind that a picture must stand."""
    rng = np.random.default_rng(7)
    names = [AWKWARD, *(f"robots.left.a quite long name of a number {index}" for index in range(13))]
    apart = np.stack([np.linspace(0, 1, 20), np.full(20, 3.0)], axis=1)
    return {
        "grid": grid_study(),
        "drawn": drawn_study(400, 2),
        "four numbers": drawn_study(600, 4),
        "one number": drawn_study(40, 1),
        "one drawn number": drawn_study(3000, 1),
        "many numbers": drawn_study(500, 14, paths=names),
        "nothing can be played": found_study(rng.uniform(0, 1, (30, 3)), np.full(30, np.nan)),
        "one variant": found_study(np.array([[0.5, 2.0, -1.0]]), np.array([0.4])),
        "all alike": found_study(apart, np.full(20, 0.4)),
        "unbounded": found_study(apart, np.full(20, np.nan), status=["unbounded"] * 20),
    }

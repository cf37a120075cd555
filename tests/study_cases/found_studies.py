"""Tables of studies as a sweep writes them, with answers that are known beforehand."""

import numpy as np
import pyarrow as pa

from mrts.plots.study_table import Knob, study_table

ELBOW, FORCE = "right/elbow torque (upper, 80 N m)", "left/fx contact wrench (lower, -60 N)"

AWKWARD = "robots.<img src=x onerror=window.broken=1>$x$.of a long, long, long, long name"


def arrow_rows(values, duration, *, status=None, limit=ELBOW, reason=None):
    """Rows of variants; those without a duration are infeasible where no status is given."""
    count = len(values)
    none = ~np.isfinite(duration)
    status = np.where(none, "infeasible", "feasible") if status is None else np.asarray(status, dtype=object)
    limits = np.broadcast_to(np.asarray(limit, dtype=object), count)
    reasons = np.broadcast_to(np.asarray(reason or "left/elbow and right/fx conflict", dtype=object), count)
    moments = 0.01 * (np.arange(count) % 50)
    columns = {"variant": pa.array(np.arange(count))}
    columns |= {f"knob {number}": pa.array(column) for number, column in enumerate(values.T)}
    texts = {
        "status": list(status),
        "reason": [text if missing else None for text, missing in zip(reasons, none, strict=True)],
        "upper_limit": [
            None if missing else f"{text} at t = {moment:.4g} s"
            for text, moment, missing in zip(limits, moments, none, strict=True)
        ],
    }
    columns |= {name: pa.array(column, pa.string()) for name, column in texts.items()}
    numbers = {"c2_upper": (0.8 / np.where(none, 1, duration)) ** 2, "duration": np.where(none, 0, duration)}
    return pa.table(columns | {name: pa.array(column, mask=none) for name, column in numbers.items()})


def found_study(values, duration, *, paths=None, planned=None, **texts):
    """The same as pictures take it."""
    names = paths or [f"knob {number}" for number in range(values.shape[1])]
    rows = arrow_rows(values, duration, **texts)
    renamed = dict(zip([f"knob {number}" for number in range(values.shape[1])], names, strict=True))
    rows = rows.rename_columns([renamed.get(name, name) for name in rows.column_names])
    knobs = [Knob(name, "m") for name in names]
    return study_table(rows, "made_up", knobs, planned or len(values))


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
        "eleven limits": found_study(
            rng.uniform(0, 1, (300, 2)),
            rng.uniform(0.3, 1, 300),
            limit=[f"left/joint_{k % 11} torque" for k in range(300)],
        ),
    }

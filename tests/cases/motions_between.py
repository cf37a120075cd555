"""Seeded motions of the shipped cells of every kind, and the same motions 50 times as dense, of the same input."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml
from motion_tables import columns_of, object_columns, write_table
from shipped_cells import sampled

import mrts
from mrts.following.coordinate import coordinate
from mrts.program.infeasibility import widening_at
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import motion_ranges

DENSE = 50
KINDS = ("path", "waypoints", "corner", "poses", "joints")
PROFILES = ("sinusoid", "trapezoid", "cubic", "quintic")
STARTS = {"planar_dual_arm": [1.25, 1.0, 0.0], "dual_ur5": [0.0, 0.1, 0.35]}
REACH = {"planar_dual_arm": [0.35, 0.35, 0.0], "dual_ur5": [0.08, 0.15, 0.15]}


@dataclass
class Drawn:
    """A motion file's keys, and the file that they are of, if one is needed."""

    keys: dict[str, Any]
    path: Any = None

    def motion(self, factor=1):
        """The motion with its own samples, or `factor` times as dense."""
        samples = (self.keys["samples"] - 1) * factor + 1
        if self.path is None:
            return sampled(self.keys | {"samples": samples})
        self.path.write_text(yaml.safe_dump(self.keys | {"samples": samples}))
        return mrts.load_motion(self.path)


def poses_of(rng, cell, count):
    """Poses from the start of the shipped motion on, within reach."""
    start, reach = np.array(STARTS[cell.name]), np.array(REACH[cell.name])
    places = np.tile(start, (count, 1))
    places[1:] += rng.uniform(-0.5, 1, (count - 1, 3)) * reach
    turns = np.zeros((count, 3))
    if cell.plane is None:
        turns[1:] = rng.uniform(-0.3, 0.3, (count - 1, 3))
    else:
        turns[1:, 2] = rng.uniform(-0.3, 0.3, count - 1)
    return [{"xyz": place.tolist(), "rpy": turn.tolist()} for place, turn in zip(places, turns, strict=True)]


def corner_of(cell, size=0.1, steps=5):
    """Two legs at a right angle, some waypoints on each."""
    start = np.array(STARTS[cell.name])
    legs = np.linspace([0, 0], [0, size], steps + 1), np.linspace([size / steps, size], [size, size], steps)
    legs = np.concatenate(legs)
    axes = [0, 1] if cell.plane else [1, 2]
    places = np.tile(start, (len(legs), 1))
    places[:, axes] += legs
    return [{"xyz": place.tolist()} for place in places]


def draw(rng, cell, kind, folder):
    """One seeded motion of a kind."""
    samples = int(rng.choice([21, 51, 101] if kind in {"corner", "poses", "joints"} else [11, 21, 51, 101]))
    profile, duration = str(rng.choice(PROFILES)), float(rng.uniform(0.4, 1.2))
    keys = {"profile": profile, "duration": duration, "samples": samples}
    if kind == "path":
        return Drawn(keys | dict(zip(("start", "end"), poses_of(rng, cell, 2), strict=True)))
    if kind == "corner":
        return Drawn(keys | {"waypoints": corner_of(cell, float(rng.uniform(0.05, 0.12)), int(rng.integers(1, 6)))})
    if kind == "waypoints":
        return Drawn(keys | {"waypoints": poses_of(rng, cell, int(rng.integers(3, 6)))})
    path = keys | {"waypoints": corner_of(cell, steps=int(rng.integers(1, 6)))}
    rows = sampled(path)
    columns = object_columns(rows, rates=False)
    if kind == "joints":
        columns = columns_of(cell, mrts.follow_object(cell, rows), ("q",))
    write_table(folder / f"{kind}.csv", columns, ".15g")
    samples = int(rng.choice([samples, 30, 64]))  # rows are samples, or they are not
    return Drawn({"samples": samples, "file" if kind == "poses" else "joints": f"{kind}.csv"}, folder / "motion.yaml")


def dense_excess(cell, motion, c2, loads=(None,)):
    """By how much all limits must move outward for a c² at the worst sample of a motion, by qpOASES."""
    dense = coordinate(cell, motion)
    worst = 0.0
    for load in loads:
        found = motion_ranges(motion_rows(cell, dense), "kernel", load)
        beyond = np.flatnonzero((found.upper < c2) | (found.lower > c2))
        if len(beyond):
            several = beyond[np.argsort(found.upper[beyond])][:40]
            problem = build_sample_problem(motion_rows(cell, dense), load=load, samples=several)
            worst = max(worst, float(np.max(widening_at(problem, c2, "qpsol:qpoases", "the dense excess"))))
    return worst

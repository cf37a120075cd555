"""Limits between samples: dense evaluation of drawn motions by HiGHS, closed forms, monotony, and what is said."""

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import yaml
from conftest import DATA
from gantries import along_x, gantries
from motion_tables import columns_of, object_columns, write_table
from shipped_cells import shipped_motion

import mrts
from mrts.following.coordinate import coordinate
from mrts.program.between_samples import BETWEEN
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
            return mrts.load_motion(self.keys | {"samples": samples})
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
    rows = mrts.load_motion(path)
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
        found = motion_ranges(motion_rows(cell, dense), load)
        beyond = np.flatnonzero((found.upper < c2) | (found.lower > c2))
        if len(beyond):
            several = beyond[np.argsort(found.upper[beyond])][:40]
            problem = build_sample_problem(motion_rows(cell, dense, solver="qpsol:qpoases"), load=load, samples=several)
            worst = max(worst, float(np.max(widening_at(problem, c2))))
    return worst


DRAWN = int(os.environ.get("BETWEEN_MOTIONS", "10"))
SEED = 11


@pytest.fixture(scope="module")
def cells(planar_cell, dual_ur5):
    return planar_cell, dual_ur5


@pytest.mark.parametrize("kind", KINDS)
def test_drawn_motions_keep_their_limits_50_times_as_dense(cells, kind, tmp_path):
    """Of described paths, curves, corners and tables of poses and joints; `BETWEEN_MOTIONS` draws more of them."""
    rng = np.random.default_rng([SEED, KINDS.index(kind)])
    overstepped = 0.0
    for number in range(max(2, DRAWN // len(KINDS))):
        cell = cells[number % 2]
        drawn = draw(rng, cell, kind, tmp_path)
        motion, dense = drawn.motion(), drawn.motion(DENSE)
        bare, found = mrts.scale(cell, motion, between=None), mrts.scale(cell, motion)
        if found.trajectory is None:
            assert bare.trajectory is None or found.motion.samples > bare.motion.samples
            continue
        assert bare.excess is None
        assert found.excess is not None
        assert found.range.upper.c2 <= bare.range.upper.c2 * (1 + 1e-9)
        assert found.range.lower.c2 >= bare.range.lower.c2
        worst = dense_excess(cell, dense, found.trajectory.c2)
        assert worst <= max(BETWEEN, found.excess.share), (kind, number)
        assert not found.excess.passes
        assert "between the samples" not in found.sentence()
        overstepped = max(overstepped, dense_excess(cell, dense, bare.trajectory.c2))
        np.testing.assert_array_equal(
            found.motion.q[np.isin(found.motion.object.time, bare.motion.object.time)], bare.motion.q
        )
    assert np.isfinite(overstepped)


@pytest.mark.quick
@pytest.mark.parametrize(("samples", "between"), [(12, 1e-4), (12, 1e-2), (40, 1e-4), (12, None)])
def test_a_velocity_whose_peak_lies_between_samples(tmp_path, samples, between):
    """A cubic profile over 2 m in 1 s is at 3 m/s half way, where even numbers of samples have none."""
    cell = gantries(tmp_path, velocity=1.5)
    found = mrts.scale(cell, along_x(samples, profile="cubic"), between=between)
    rows = {row.name.kind for row in found.range.upper.rows}
    assert rows == {"velocity"}
    exact, share = (1.5 / 3) ** 2, np.sqrt(found.range.upper.c2) * 3 / 1.5 - 1
    if between is None:
        u = np.linspace(0, 1, samples)
        assert found.range.upper.c2 == pytest.approx((1.5 / np.max(12 * u * (1 - u))) ** 2, rel=1e-9)
        assert found.excess is None
        assert found.motion.samples == samples
    else:
        assert -1e-9 <= share <= between
        assert found.range.upper.c2 == pytest.approx(exact, rel=2 * between + 1e-9)
        assert found.excess.share <= between


def trapezoid_lift(samples):
    """The redundant cell's lift by a trapezoid, whose acceleration jumps at a third and at two thirds of the time."""
    return mrts.load_motion(shipped_motion("redundant", profile="trapezoid", samples=samples))


def test_jumps_of_acceleration_are_found_at_any_number_of_samples():
    redundant = mrts.load_cell(DATA.parent / "redundant" / "cell.yaml")
    found = [mrts.scale(redundant, trapezoid_lift(samples)).range.upper.c2 for samples in (15, 16, 29, 57, 449)]
    exact = mrts.scale(redundant, trapezoid_lift(3001), between=None).range.upper.c2  # 3000 / 3: corners are samples
    np.testing.assert_allclose(found, exact, rtol=BETWEEN)


@pytest.mark.parametrize("load", ["guaranteed", "grid:3"])
def test_every_corner_of_the_load_keeps_its_limits_between_samples(dual_ur5, load):
    cell = dual_ur5.with_variation(mass=(0.5, 1.5))
    path = {"duration": 0.8, "samples": 15, "profile": "sinusoid"}
    path |= {"start": {"xyz": [0, 0.1, 0.35]}, "end": {"xyz": [0.05, 0.25, 0.5]}}
    found = mrts.scale(cell, mrts.load_motion(path), load=load)
    assert found.motion.samples > 15 or found.excess.share > 0
    dense = mrts.load_motion(path | {"samples": 701})
    loads = [point.load for point in found.load.points]
    assert dense_excess(cell, dense, found.trajectory.c2, loads) <= BETWEEN
    assert all(len(of_load.samples.time) == found.motion.samples for of_load in found.load.ranges)
    carried = mrts.torques_for_load(found, cell.load_box.load_at({"mass": 1.2}))
    assert carried.trajectory.torque.shape == found.trajectory.torque.shape
    assert (carried.excess is None) == (load != "guaranteed")


def test_a_coarse_table_of_joints_says_that_its_splines_are_ours(cells, tmp_path):
    """21 rows around a corner, 64 samples on their splines: told by how much c²⁺ is less than at the samples."""
    cell = cells[0]
    path = {"duration": 0.8, "profile": "quintic", "samples": 21, "waypoints": corner_of(cell, steps=2)}
    followed = mrts.follow_object(cell, mrts.load_motion(path))
    write_table(tmp_path / "joints.csv", columns_of(cell, followed, ("q",)), ".15g")
    (tmp_path / "motion.yaml").write_text("joints: joints.csv\nsamples: 30\n")
    found = mrts.scale(cell, mrts.load_motion(tmp_path / "motion.yaml"))
    told = [remark for remark in found.warnings if remark.code == "between-samples"]
    assert len(told) == 1
    assert "spline that mrts lays through them" in told[0].text
    bare = mrts.scale(cell, mrts.load_motion(tmp_path / "motion.yaml"), between=None)
    fall = 100 * (1 - found.range.upper.c2 / bare.range.upper.c2)
    assert f"{fall:.2g} % less" in told[0].text

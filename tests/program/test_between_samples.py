"""Limits between samples: dense evaluation of drawn motions by HiGHS, closed forms, monotony, and what is said."""

import os

import numpy as np
import pytest
from conftest import DATA
from gantries import along_x, gantries
from motion_tables import columns_of, write_table
from motions_between import DENSE, KINDS, corner_of, dense_excess, draw
from shipped_cells import sampled, shipped_motion

import mrts
from mrts.motion.motion_file import MotionDescription, sample_motion
from mrts.program.between_samples import BETWEEN

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


@pytest.fixture(scope="module")
def redundant():
    return mrts.load_cell(DATA.parent / "redundant" / "cell.yaml")


def trapezoid_lift(samples):
    """The redundant cell's lift by a trapezoid, whose acceleration jumps at a third and at two thirds of the time."""
    return sampled(shipped_motion("redundant", profile="trapezoid", samples=samples))


def test_jumps_of_acceleration_are_found_at_any_number_of_samples(redundant):
    found = [mrts.scale(redundant, trapezoid_lift(samples)).range.upper.c2 for samples in (15, 16, 29, 57, 449)]
    exact = mrts.scale(redundant, trapezoid_lift(3001), between=None).range.upper.c2  # 3000 / 3: corners are samples
    np.testing.assert_allclose(found, exact, rtol=BETWEEN)


@pytest.mark.parametrize("load", ["guaranteed", "grid:3"])
def test_every_corner_of_the_load_keeps_its_limits_between_samples(dual_ur5, load):
    cell = dual_ur5.with_variation(mass=(0.5, 1.5))
    path = MotionDescription(
        duration=0.8, samples=15, profile="sinusoid", start={"xyz": [0, 0.1, 0.35]}, end={"xyz": [0.05, 0.25, 0.5]}
    )
    found = mrts.scale(cell, sample_motion(path), load=load)
    assert found.motion.samples > 15 or found.excess.share > 0
    dense = sample_motion(path.model_copy(update={"samples": 701}))
    loads = [point.load for point in found.load.points]
    assert dense_excess(cell, dense, found.trajectory.c2, loads) <= BETWEEN
    assert all(len(of_load.samples.time) == found.motion.samples for of_load in found.load.ranges)
    carried = mrts.torques_for_load(found, cell.load_box.load_at({"mass": 1.2}))
    assert carried.trajectory.torque.shape == found.trajectory.torque.shape
    assert (carried.excess is None) == (load != "guaranteed")


def test_a_coarse_table_of_joints_says_that_its_splines_are_ours(cells, tmp_path):
    """21 rows around a corner, 64 samples on their splines: told by how much c²⁺ is less than at the samples."""
    cell = cells[0]
    path = MotionDescription(duration=0.8, profile="quintic", samples=21, waypoints=corner_of(cell, steps=2))
    followed = mrts.follow_object(cell, sample_motion(path))
    write_table(tmp_path / "joints.csv", columns_of(cell, followed, ("q",)), ".15g")
    (tmp_path / "motion.yaml").write_text("joints: joints.csv\nsamples: 30\n")
    found = mrts.scale(cell, mrts.load_motion(tmp_path / "motion.yaml"))
    told = [remark for remark in found.warnings if remark.code == "between-samples"]
    assert len(told) == 1
    assert "spline that mrts lays through them" in told[0].text
    bare = mrts.scale(cell, mrts.load_motion(tmp_path / "motion.yaml"), between=None)
    fall = 100 * (1 - found.range.upper.c2 / bare.range.upper.c2)
    assert f"{fall:.2g} % less" in told[0].text

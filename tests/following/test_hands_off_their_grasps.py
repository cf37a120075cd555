"""Joints whose hands are a little off their grasps: moved onto them within a bound, or refused; how far in one call."""

import numpy as np
import pytest
from cell_bank import random_planar_cell, random_spatial_cell
from conftest import UR5
from motion_tables import columns_of, perturbed, write_table
from scipy.interpolate import CubicSpline
from shipped_cells import cell_file, shipped

import mrts
from mrts.base.arrays import apply
from mrts.base.manifest import GEOMETRY
from mrts.cli import main
from mrts.following.coordinate import coordinate, grasp_gaps, tip_rates
from mrts.following.coordinated_motion import CoordinatedMotion, carried_by_each, carried_by_first
from mrts.following.denser_motion import between_samples
from mrts.following.tracking import CONDITION_LIMIT, check_regular, nearest_rates
from mrts.kernel.tracking import closure_sizes

ROUNDING = 1e-12
"""Of what is found in another order of the same operations, of sizes about 1."""


def assert_same(cell, motion):
    """The library's sizes are those of numpy."""
    inputs = motion.inputs(cell.load) | {GEOMETRY: cell.geometry}
    found = closure_sizes(cell.library, inputs, motion.object.position, cell.geometry, cell.wrench_rows)
    distance, angle, *rates = found
    carried = carried_by_each(cell, motion.object.time, motion.q, motion.dq, motion.ddq)
    gaps = grasp_gaps(cell, motion.object, motion.q)
    np.testing.assert_allclose([distance, angle], np.max(gaps, axis=2), atol=ROUNDING)
    for index, (robot, own) in enumerate(zip(cell.robots, carried, strict=True)):
        pairs = zip(tip_rates(cell, robot, own), tip_rates(cell, robot, motion.object), strict=True)
        for (ours, expected), size, slip in zip(pairs, rates[::2], rates[1::2], strict=True):
            np.testing.assert_allclose(size[index], max(np.max(np.abs(ours)), np.max(np.abs(expected))), rtol=ROUNDING)
            np.testing.assert_allclose(slip[index], np.max(np.abs(ours - expected)), rtol=ROUNDING, atol=ROUNDING)


def moved(motion, rng, size):
    """A motion whose joints are off by about so much."""
    joints = (part + size * rng.normal(size=part.shape) for part in (motion.q, motion.dq, motion.ddq))
    return CoordinatedMotion(motion.object, *joints)


@pytest.mark.quick
@pytest.mark.parametrize(
    ("draw", "arms"),
    [(random_planar_cell, 1), (random_planar_cell, 3), (random_spatial_cell, 1), (random_spatial_cell, 2)],
)
def test_the_library_finds_what_numpy_finds(tmp_path, draw, arms):
    rng = np.random.default_rng(arms)
    given = draw(rng, tmp_path, arms)
    cell = mrts.load_cell(given.cell_file)
    motion = mrts.follow_object(cell, given.motion)
    for size in (0.0, 1e-6, 1e-3, 0.3):
        assert_same(cell, moved(motion, rng, size))


def test_whole_chunks_and_what_is_left(dual_ur5):
    """The largest of all samples, wherever it is, with one thread or two."""
    motion = mrts.follow_object(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml"))
    rng = np.random.default_rng(0)
    for samples in (2, 257, 515):
        some = motion.at(np.linspace(0, motion.samples - 1, samples).astype(int))
        q = some.q.copy()
        q[rng.integers(samples), 3] += 1e-2
        assert_same(dual_ur5, CoordinatedMotion(some.object, q, some.dq, some.ddq))


@pytest.mark.quick
@pytest.mark.parametrize("elbow", [0.0, 1e-7, 0.5])
def test_a_singular_arm_keeps_what_it_was_given_in_the_direction_it_lost(elbow, planar_cell, lift):
    """Stretched out at one end, or nearly so: as with the pseudoinverse of every Jacobian."""
    motion = mrts.follow_object(planar_cell, lift)
    q, dq = motion.q.copy(), motion.dq + 0.1
    q[-1, 1] = elbow
    ours = nearest_rates(planar_cell, motion.object, np.arange(len(q)), q, dq, motion.ddq)[0]
    jacobians = planar_cell.functions("kinematics", len(q), {"q": q})["jacobian"]
    for robot, joints in zip(planar_cell.robots, planar_cell.joint_slices.values(), strict=True):
        J, (velocity, _) = jacobians[:, :, joints], tip_rates(planar_cell, robot, motion.object)
        inverse = np.linalg.pinv(J, rcond=1 / CONDITION_LIMIT)
        expected = dq[:, joints] + apply(inverse, velocity - apply(J, dq[:, joints]))
        np.testing.assert_allclose(ours[:, joints], expected, rtol=1e-9, atol=1e-9)


def test_a_singular_arm_is_named_with_the_sample(planar_cell):
    q = np.full((3, 6), 0.7)
    check_regular(planar_cell, np.arange(3.0), q)
    q[1, 4] = 0  # stretched out
    with pytest.raises(mrts.MotionError, match=r"'right' .*sample 1 \(t = 1 s\)"):
        check_regular(planar_cell, np.arange(3.0), q)


def assert_closed(cell, motion, tolerance=1e-9):
    """By the arms' forward kinematics: positions, velocities and accelerations of all hands fit the object."""
    carried = carried_by_each(cell, motion.object.time, motion.q, motion.dq, motion.ddq)
    for own in carried:
        np.testing.assert_allclose(own.position, motion.object.position, atol=tolerance)
        np.testing.assert_allclose(own.rotation, motion.object.rotation, atol=tolerance)
        np.testing.assert_allclose(own.twist, motion.object.twist, atol=tolerance)
        np.testing.assert_allclose(own.acceleration, motion.object.acceleration, atol=100 * tolerance)


def assert_own_derivatives(motion, tolerance):
    """Velocities and accelerations are those of the positions: differences of these in between."""
    time = motion.object.time
    line = CubicSpline(time, motion.q)
    inner = slice(5, -5)
    np.testing.assert_allclose(line(time, 1)[inner], motion.dq[inner], atol=tolerance)
    np.testing.assert_allclose(line(time, 2)[inner], motion.ddq[inner], atol=100 * tolerance)
    place = CubicSpline(time, motion.object.position)
    np.testing.assert_allclose(place(time, 1)[inner], motion.object.twist[inner, :3], atol=tolerance)


@pytest.mark.parametrize("kept", [("q", "dq", "ddq"), ("q", "dq"), ("q",)])
def test_hands_a_little_off_are_moved_onto_the_grasps(tmp_path, dual_ur5, exact, kept):
    """Waves of about 1 mm and 2 mrad: the range is that of the exact motion but for what the waves themselves cost."""
    followed, c2 = exact["turn", 101]
    table = mrts.load_motion(
        write_table(tmp_path / "joints.csv", columns_of(dual_ur5, perturbed(followed, 8e-4), kept))
    )
    found = mrts.scale(dual_ur5, table, between=None)
    assert_closed(dual_ur5, found.motion)
    assert_own_derivatives(found.motion, 3e-4)
    assert found.range.upper.c2 == pytest.approx(c2, rel=0.03)
    (remark,) = found.motion.remarks
    assert remark.code == "chain-closed"
    assert 0 <= remark.sample < 101
    assert "'left'" in remark.text or "'right'" in remark.text
    moved_by = np.max(np.abs(found.motion.q - np.column_stack([table.positions[name] for name in table.positions])))
    assert f"by more than {moved_by:.3g} rad or m" in remark.text


def test_the_bound_on_the_gap_is_an_option(tmp_path, dual_ur5, exact, capsys):
    path = write_table(tmp_path / "joints.csv", columns_of(dual_ur5, perturbed(exact["turn", 101][0], 4e-3)))
    command = ["scale", str(UR5 / "cell.yaml"), str(path)]
    assert main(command) == 2
    said = capsys.readouterr().err
    assert "The tip of 'right' is off its grasp by" in said
    assert "0.002 m and 0.005 rad are allowed" in said
    assert main([*command, "--closure", "0.02"]) == 0
    closed = mrts.scale(dual_ur5, mrts.load_motion(path), closure=mrts.ClosureBound(0.02)).motion
    assert_closed(dual_ur5, closed)
    for text, words in (
        ("much", "--closure = 'much': must be a number in m, or m and rad"),
        ("-1", "--closure: position = -1.0: must be > 0"),
    ):
        assert main([*command, f"--closure={text}"]) == 2
        assert words in capsys.readouterr().err
    with pytest.raises(mrts.InputError, match=r"closure.*ClosureBound"):
        mrts.scale(dual_ur5, mrts.load_motion(path), closure=0.02)


def test_rounding_stays_rounding_where_arms_are_stretched_between_samples(tmp_path):
    """Two arms side by side turn their elbows through zero: on the grasps, 1e-10 rad would be a large acceleration."""
    keys = shipped()
    left, right = keys["robots"]
    for pose in ("base", "grasp"):
        x, *others = left[pose]["xyz"]
        right[pose] = {"xyz": [x + 0.5, *others]}
    cell = mrts.load_cell(cell_file(tmp_path, keys))
    time = np.linspace(0, 1, 3)
    rate, none = np.tile([0.3, 0.5, -0.8], (3, 2)), np.zeros((3, 6))
    q = np.tile([0.6, -0.125, -0.475], 2) + time[:, None] * rate
    carried = carried_by_first(cell, time, q, rate, none).object
    given = CoordinatedMotion(carried, q + 1e-10 * np.eye(6)[3], rate, none)
    between = between_samples(cell, coordinate(cell, given), np.array([0.2, 0.25]))
    np.testing.assert_allclose(between.ddq, 0, atol=1e-6)

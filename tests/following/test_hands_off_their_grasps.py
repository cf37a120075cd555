"""Joints whose hands are a little off their grasps: moved onto them within a bound, or refused."""

import numpy as np
import pytest
from conftest import UR5
from motion_tables import columns_of, perturbed, write_table
from scipy.interpolate import CubicSpline

import mrts
from mrts.cli import main
from mrts.following.coordinated_motion import tip_motions
from mrts.following.grasp_closure import grasp_gaps
from mrts.following.tracking import tip_rates


def assert_closed(cell, motion, tolerance=1e-9):
    """By the arms' forward kinematics: positions, velocities and accelerations of all hands fit the object."""
    tips = tip_motions(cell, motion.q, motion.dq, motion.ddq)
    gaps = grasp_gaps(cell, motion.object, tips)
    assert np.max(gaps) < tolerance
    for robot, tip in zip(cell.robots, tips, strict=True):
        velocity, acceleration = tip_rates(cell, robot, motion.object)
        np.testing.assert_allclose(tip.velocity, velocity, atol=tolerance)
        np.testing.assert_allclose(tip.acceleration, acceleration, atol=100 * tolerance)


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

"""Smooth timing against an independent program: the same mathematics by cvxpy."""

import numpy as np
import pytest
from changed_robots import with_robots
from conftest import DATA
from gantries import UPHILL, along_x, gantries, uphill_gantries
from random_motors import equipped
from shipped_cells import shipped_motion
from smooth_program import Rates, quintic_path, smooth_timing, with_third

import mrts

RATE = 11.0
"""[1/s]; of the torque limits, as Franka publishes them."""

SAME = 1e-3
"""Share of the duration: both stop where a step wins less than 1e-4 or 1e-5 of it."""


def shipped(name):
    """A shipped cell, its motion, and the torque rates that are asked for."""
    cell = mrts.load_cell(DATA.parent / name / "cell.yaml")
    limits = np.concatenate([robot.torque_upper for robot in cell.robots])
    return cell, mrts.MotionDescription.model_validate(shipped_motion(name)), RATE * limits


@pytest.mark.parametrize("name", ["planar_dual_arm", pytest.param("dual_ur5", marks=pytest.mark.slow)])
def test_torque_rates_on_the_shipped_cells(name):
    cell, description, rates = shipped(name)
    ours = mrts.retime(cell, mrts.sample_motion(description), rates=RATE, between=None)
    theirs = smooth_timing(cell, quintic_path(cell, description, description.samples), Rates(torque=rates))
    assert ours.duration == pytest.approx(theirs.duration, rel=SAME)


def test_jerk_and_wrench_rates_together():
    cell, description, rates = shipped("planar_dual_arm")
    jerk, wrench = np.full(6, 3e3), np.tile([60.0, 60.0, 30.0], 2)
    limited = with_robots(equipped(cell, jerk=3e3), contact_rate=wrench[:3])
    ours = mrts.retime(limited, mrts.sample_motion(description), rates=RATE, between=None)
    path = with_third(ours.pieces[0].piece.path)
    theirs = smooth_timing(cell, path, Rates(torque=rates, jerk=jerk, wrench=wrench))
    assert ours.duration == pytest.approx(theirs.duration, rel=SAME)
    alone = smooth_timing(cell, path, Rates(torque=rates))
    assert theirs.duration > (1 + 2 * SAME) * alone.duration  # they do limit it


def test_every_load_of_a_box_is_carried():
    """One timing for all corners of the box, each with torques of its own."""
    cell, description, rates = shipped("planar_dual_arm")
    cell = cell.with_variation(mass=(0.5, 2.0), izz=(0.5, 3.0))
    ours = mrts.retime(cell, mrts.sample_motion(description), rates=RATE, between=None)
    loads = [cell.load_box.load_at({"mass": k, "izz": 1.0}) for k in (0.5, 2.0)]  # the bar does not turn
    theirs = smooth_timing(cell, with_third(ours.pieces[0].piece.path), Rates(torque=rates), loads=loads)
    alone = smooth_timing(cell, with_third(ours.pieces[0].piece.path), Rates(torque=rates))
    assert ours.duration == pytest.approx(theirs.duration, rel=SAME)
    assert theirs.duration > (1 + 2 * SAME) * alone.duration


def test_friction_presses_and_helps(tmp_path):
    cell = uphill_gantries(tmp_path, viscous=12.0, coulomb=np.array([1.0, 0.0, 0.0]))
    rates = np.concatenate([3.0 * robot.torque_upper for robot in cell.robots])
    ours = mrts.retime(cell, along_x(81, profile="quintic"), rates=3.0, between=None)
    path = with_third(ours.pieces[0].piece.path)
    theirs = smooth_timing(cell, path, Rates(torque=rates))
    ideal = smooth_timing(gantries(tmp_path, gravity=(-UPHILL, 0, 0)), path, Rates(torque=rates))
    assert ours.duration == pytest.approx(theirs.duration, rel=SAME)
    assert abs(theirs.duration / ideal.duration - 1) > 2 * SAME


def test_torques_given_at_the_ends(planar_cell):
    """With other torques that hold still at the end than the best ones the motion takes longer."""
    _, description, rates = shipped("planar_dual_arm")
    motion = mrts.sample_motion(description)
    free = mrts.retime(planar_cell, motion, rates=RATE, between=None)
    path = with_third(free.pieces[0].piece.path)
    held = holding_torque(planar_cell, path.motion, squeeze=1.5)
    ours = mrts.retime(planar_cell, motion, rates=RATE, between=None, end_torque=held)
    theirs = smooth_timing(planar_cell, path, Rates(torque=rates), end_torque=(None, held))
    assert ours.duration == pytest.approx(theirs.duration, rel=SAME)
    assert theirs.duration >= (1 - SAME) * free.duration


def holding_torque(cell, motion, squeeze):
    """Torques that hold the object at the end of a motion, the hands pressed together by a force [N]."""
    terms = cell.functions("terms", motion.samples, motion.inputs(cell.load))
    B, Q, J, torque = terms["B"][-1], terms["Q"][-1], terms["J"][-1], terms["G"][-1].copy()
    wrench = np.linalg.lstsq(B, Q, rcond=None)[0]
    inner = np.linalg.svd(B)[2][len(B) :]
    pressed = inner.T @ inner[:, 0]
    wrench += squeeze * pressed / np.max(np.abs(pressed))
    for name, joints in cell.joint_slices.items():
        torque[joints] += J[:, joints].T @ wrench[cell.wrench_slices[name]]
    return torque

"""What a motion asks of its motors: against closed forms, finer sums, and where it is told."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from changed_robots import with_left
from scipy.interpolate import make_interp_spline

import mrts
from mrts.following.coordinate import coordinate
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.output.trajectory_table import trajectory_columns, trajectory_csv
from mrts.scaling.scaled_trajectory import ScaledTrajectory

pytestmark = pytest.mark.quick


def duty_of(cell, time, torque, dq=0.0, ddq=0.0, **known):
    """The first joint of a cell, all others at rest without torques."""
    motors = replace(mrts.JointMotors.unknown(3), **{name: np.full(3, value) for name, value in known.items()})
    limits = {"torque_lower": np.full(3, -10.0), "torque_upper": np.full(3, 10.0), "velocity_limit": np.full(3, 4.0)}
    still, first = np.zeros((len(time), 6)), np.eye(6)[0]
    carried = mrts.ObjectMotion(time, still[:, :3], np.tile(np.eye(3), (len(time), 1, 1)), still, still)
    motion = CoordinatedMotion(carried, still, still + np.outer(dq, first), still + np.outer(ddq, first))
    done = ScaledTrajectory(with_left(cell, motors=motors, **limits), motion, 1.0, np.outer(torque, first), still)
    return done.duty["left"]


def test_root_mean_square_of_a_line_and_of_a_sine(planar_cell):
    time = np.array([0.0, 0.5, 0.6, 3.0])  # steps of any length
    ramp = duty_of(planar_cell, time, 6.0 * time / 3.0, rated=3.0)
    assert ramp.rms_torque[0] == pytest.approx(6.0 / np.sqrt(3), rel=1e-14)  # ∫ of a square along a line, exactly
    assert ramp.rated_share[0] == pytest.approx(2.0 / np.sqrt(3), rel=1e-14)
    assert ramp.peak_torque[0] == 6.0
    assert ramp.torque_share[0] == pytest.approx(0.6)
    assert ramp.torque_rate[0] == pytest.approx(2.0, rel=1e-14)
    fine = np.linspace(0, 2 * np.pi, 20001)
    sine = duty_of(
        planar_cell, fine, 5.0 * np.sin(fine), dq=3.0 * np.sin(fine), ddq=3.0 * np.cos(fine), jerk=1.5, torque_rate=10.0
    )
    assert sine.rms_torque[0] == pytest.approx(5.0 / np.sqrt(2), rel=1e-7)  # lines between 20000 samples
    assert sine.drive_power[0] == pytest.approx(15.0, rel=1e-7)
    assert sine.brake_power[0] == 0.0
    assert sine.speed_share[0] == pytest.approx(0.75, rel=1e-7)
    assert sine.jerk_share[0] == pytest.approx(2.0, rel=1e-6)
    assert sine.torque_rate_share[0] == pytest.approx(0.5, rel=1e-6)
    assert sine.rated_share[0] == 0.0  # nothing known


@pytest.fixture(scope="module")
def cell(planar_cell):
    """The paper's cell with friction and ratings of its left arm."""
    left = planar_cell.robots[0]
    motors = replace(
        left.motors,
        armature=np.array([0.3, 0.2, 0.05]),
        coulomb=np.array([3.0, 2.0, 0.5]),
        rated=np.array([30.0, np.inf, 1.0]),
        torque_rate=np.full(3, 2000.0),
        jerk=np.full(3, 900.0),
    )
    return with_left(planar_cell, motors=motors)


@pytest.fixture(scope="module")
def result(cell, lift):
    return mrts.scale(cell, lift)


def test_the_duty_of_a_result_is_that_of_its_torques(result):
    done = result.trajectory
    fine = np.linspace(0, done.duration, 200001)
    torque = make_interp_spline(done.time, done.torque, k=1)(fine)
    rms = np.sqrt(np.trapezoid(torque**2, fine, axis=0) / done.duration)
    duty = done.duty
    np.testing.assert_allclose(np.concatenate([one.rms_torque for one in duty.values()]), rms, rtol=1e-6)
    left = duty["left"]
    np.testing.assert_allclose(left.rated_share, [left.rms_torque[0] / 30, 0.0, left.rms_torque[2]])
    np.testing.assert_allclose(left.torque_share, left.peak_torque / result.cell.robots[0].torque_upper)
    assert np.max(np.concatenate([one.torque_share for one in duty.values()])) <= 1 + 1e-8
    assert left.torque_rate[0] == np.max(np.abs(np.diff(done.torque[:, 0]) / np.diff(done.time)))


def test_a_table_has_the_friction_apart_and_is_a_motion_again(result, lifted, tmp_path):
    columns = trajectory_columns(result)
    names = list(columns)
    assert names.index("tau_friction.left/shoulder") == names.index("tau.right/wrist") + 1
    inner = slice(1, -1) if len(columns["t"]) > result.motion.samples else slice(None)  # rows at rest
    friction = result.trajectory.friction
    np.testing.assert_array_equal(columns["tau_friction.left/elbow"][inner], friction[:, 1])
    assert np.all(columns["tau_friction.right/elbow"] == 0)
    outer = columns["tau_friction.left/elbow"][[0, -1]]
    assert np.all(outer == 0)  # what holds still has no friction to overcome
    assert np.all(np.sign(columns["dq.left/elbow"]) * columns["tau_friction.left/elbow"] >= 0)
    assert set(np.unique(np.abs(friction[:, 1]))) <= {0.0, 2.0}
    mrts.write_trajectory_csv(result, tmp_path / "played.csv")
    again = coordinate(result.cell, mrts.load_motion(tmp_path / "played.csv"), None)
    assert again.samples == result.motion.samples
    head = next(csv.reader([trajectory_csv(lifted).split("\n", 1)[0]]))
    assert not [name for name in head if name.startswith("tau_friction")]


def test_power_above_its_limit_is_a_warning_that_names_the_worst(cell, lift, result):
    power = np.abs(result.trajectory.power)
    most = float(np.max(np.abs(np.sum(result.trajectory.power, axis=1))))
    joint = int(np.argmax(np.max(power, axis=0)))
    place = divmod(joint, 3)
    motors = [replace(robot.motors, power=np.full(3, 1e4)) for robot in cell.robots]
    motors[place[0]].power.flags.writeable = True
    motors[place[0]].power[place[1]] = np.max(power) / 2
    limited = replace(
        cell,
        power_limit=most * 1.01,
        robots=tuple(replace(robot, motors=motor) for robot, motor in zip(cell.robots, motors, strict=True)),
    )
    warned = mrts.scale(limited, lift)
    (said,) = [warning for warning in warned.warnings if warning.code == "above-power"]
    assert said.text.startswith(f"{cell.joint_names[joint]} power reaches ")
    assert "200 % of its limit" in said.text
    share = np.concatenate([duty.power_share for duty in warned.trajectory.duty.values()])
    assert np.isclose(share[joint], 2.0)
    supply = mrts.scale(replace(cell, power_limit=most * 0.99), lift)
    (said,) = [warning for warning in supply.warnings if warning.code == "above-power"]
    assert said.text.startswith("all motors together power reaches ")


def test_motors_above_their_rating_are_a_warning_until_the_motion_is_slow_enough(cell, lift, result):
    (said,) = [warning for warning in result.warnings if warning.code == "above-rated"]
    worst = result.trajectory.duty["left"].rated_share
    assert f"{100 * max(worst):.0f} % of what its motor bears" in said.text
    relaxed = replace(cell.robots[0].motors, rated=np.full(3, 1e4))
    easy = mrts.scale(with_left(cell, motors=relaxed), lift)
    assert not [warning for warning in easy.warnings if warning.code == "above-rated"]

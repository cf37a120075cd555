"""A controller that is 1 ms late, in MuJoCo: what was planned to be far from its limit stays below it."""

import mujoco
import numpy as np
import pytest
import yaml
from conftest import DATA
from mujoco_cells import POSITION_GAIN, STEP, VELOCITY_GAIN, contact_wrenches, simulator
from scipy.interpolate import CubicSpline

import mrts

UR5 = DATA.parent / "dual_ur5"
DELAY = 1e-3  # s: torques act that late, of a state that was measured that long ago
SETTLED = 0.01  # s; the first steps settle the springs that welds are


def played(rule):
    """Largest share of each wrench limit, planned and played by a controller that is late, Shape (12,) each."""
    cell = mrts.load_cell(UR5 / "cell.yaml")
    description = yaml.safe_load((UR5 / "lift_and_turn.yaml").read_text()) | {"samples": 1001}
    motion = mrts.sample_motion(mrts.MotionDescription.model_validate(description))
    result = mrts.scale(cell, motion, distribute=rule, weights=1)
    done, given = result.trajectory, result.motion.object
    urdf = UR5 / yaml.safe_load((UR5 / "cell.yaml").read_text())["robots"][0]["urdf"]
    model, data = simulator(cell, urdf, (given.position[0], given.rotation[0]))
    joints = [f"{robot.name}/{joint}" for robot in cell.robots for joint in robot.joints]
    q_index = [model.joint(name).qposadr[0] for name in joints]
    v_index = [model.joint(name).dofadr[0] for name in joints]
    data.qpos[q_index] = done.q[0]
    torque, wanted = CubicSpline(done.time, done.torque), CubicSpline(done.time, done.q)
    limit = np.concatenate([robot.wrench_upper for robot in cell.robots])
    late, states, shares = round(DELAY / STEP), [], []
    for step in range(int(done.duration / STEP)):
        states.append((data.qpos[q_index].copy(), data.qvel[v_index].copy()))
        q, dq = states[max(0, step - late)]
        t = max(0, step - late) * STEP
        feedback = POSITION_GAIN * (wanted(t) - q) + VELOCITY_GAIN * (wanted(t, 1) - dq)
        data.qfrc_applied[v_index] = torque(t) + feedback
        mujoco.mj_step(model, data)
        shares.append(np.abs(contact_wrenches(cell, model, data)) / limit)
    return np.max(np.abs(done.wrench) / limit, axis=0), np.max(shares[int(SETTLED / STEP) :], axis=0)


@pytest.fixture(scope="module")
def runs():
    return {rule: played(rule) for rule in ("least-torque", "reserve")}


def test_least_torques_that_weigh_alike_overstep_the_wrenches_that_they_put_at_their_limits(runs):
    planned, reached = runs["least-torque"]
    print("planned", planned.round(3), "played", reached.round(3))
    at_limit = planned > 1 - 1e-6
    assert np.count_nonzero(at_limit) == 6
    assert np.all(reached[at_limit] > 1)
    assert np.max(reached) > 1.02


def test_reserve_keeps_all_of_them_far_from_their_limits(runs):
    planned, reached = runs["reserve"]
    print("planned", planned.round(3), "played", reached.round(3))
    assert np.max(planned) == pytest.approx(0.4, abs=1e-3)
    assert np.max(reached) < 0.45

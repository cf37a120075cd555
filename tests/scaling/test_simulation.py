"""Closed loop in MuJoCo: the scaled torques carry the object along its path, in a model that MuJoCo builds itself.

Arms from the same URDF through MuJoCo's own parser, the object a free body welded to both hands. The torques of
c = √c²⁺ are played open loop with a small tracking feedback.
"""

import numpy as np
import pytest
from conftest import UR5
from mujoco_cells import closed_loop, urdf_of, weld_wrench
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation
from shipped_cells import sampled, shipped_motion

import mrts


@pytest.fixture(scope="module")
def run():
    cell = mrts.load_cell(UR5 / "cell.yaml").without_velocity_limits()
    result = mrts.scale(cell, sampled(shipped_motion("dual_ur5", samples=1001)))
    done, given = result.trajectory, result.motion.object
    torque, path = CubicSpline(done.time, done.torque), CubicSpline(done.time, given.position)
    B = cell.functions("terms", len(given.time), result.motion.inputs(cell.load))["B"]
    arms = [slice(0, 6), slice(6, 12)]
    on_object = [np.einsum("nij,nj->ni", B[:, :, arm], done.wrench[:, arm]) for arm in arms]
    wrenches = [CubicSpline(done.time, wrench) for wrench in on_object]
    log = {"path": [], "feedback": [], "forward": [], "weld": [], "wrench": []}
    for model, data, t, feedback, _ in closed_loop(cell, urdf_of(UR5), done, torque):
        log["path"].append(data.body("object").xpos - path(data.time))
        log["feedback"].append(feedback)
        log["forward"].append(torque(t))
        log["weld"].append([weld_wrench(model, data, weld) for weld in range(2)])
        log["wrench"].append([wrench(t) for wrench in wrenches])
    final = Rotation.from_matrix(data.body("object").xmat.reshape(3, 3) @ given.rotation[-1].T).magnitude()
    return {name: np.array(values) for name, values in log.items()} | {"turn": final}


@pytest.mark.quick
def test_the_object_follows_its_path(run):
    print("largest path error [m]", np.max(np.linalg.norm(run["path"], axis=1)), "final turn [rad]", run["turn"])
    assert np.max(np.linalg.norm(run["path"], axis=1)) < 5e-4
    assert run["turn"] < 1e-3


def test_the_feedback_stays_small(run):
    share = np.max(np.abs(run["feedback"]), axis=0) / np.max(np.abs(run["forward"]), axis=0)
    print("feedback / feed-forward by joint", np.round(share, 4))
    assert np.max(share) < 0.01


def test_weld_forces_are_the_reported_wrenches(run):
    late = slice(200, None)  # the first steps settle the springs that welds are
    off = np.abs(run["weld"] - run["wrench"])[late]
    for part, unit in ((slice(0, 3), "N"), (slice(3, 6), "N m")):
        size = np.max(np.abs(run["wrench"][:, :, part]))
        print("weld against reported", unit, np.max(off[:, :, part]), "of", size)
        assert np.max(off[:, :, part]) < 0.01 * size

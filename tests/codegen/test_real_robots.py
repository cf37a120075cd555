"""URDFs that people really have, against Pinocchio on the same files."""

import numpy as np
import pinocchio as pin
import pytest
import yaml
from casadi_cells import casadi_cell
from published_robots import CASES, ROBOTS, single_arm_cell, urdf_path
from random_cells import chain_model, configuration

STATES = 1000
TOLERANCE = 1e-10  # relative; both sides are exact recursions


@pytest.mark.parametrize("name", CASES)
def test_terms_equal_pinocchio(name, tmp_path):
    reference, tip = CASES[name]
    model = chain_model(urdf_path(reference), tip)
    model.gravity.linear = np.array([0.3, -0.2, -9.81])
    data, frame = model.createData(), model.getFrameId(tip)
    cell = casadi_cell(single_arm_cell(tmp_path, reference, tip, model.nv))
    assert list(cell.robots[0].joints) == list(model.names)[1:]

    rng = np.random.default_rng(12)
    q, dq, ddq = (rng.uniform(-2, 2, (STATES, model.nv)) for _ in range(3))
    inputs = {
        "q": q,
        "dq": dq,
        "ddq": ddq,
        "object_rotation": np.broadcast_to(np.eye(3), (STATES, 3, 3)),
        "object_twist": np.zeros(6),
        "object_acceleration": np.zeros(6),
        "load": cell.load,
    }
    poses = cell.functions("kinematics", STATES, inputs)
    bias = cell.functions("bias_acceleration", STATES, inputs)["bias_acceleration"]
    terms = cell.functions("terms", STATES, inputs)
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    rows = {key: [] for key in ("position", "rotation", "jacobian", "bias", "E", "G", "A")}
    for k in range(STATES):
        qk = configuration(model, q[k])
        pin.forwardKinematics(model, data, qk, dq[k], np.zeros(model.nv))
        pin.updateFramePlacements(model, data)
        rows["position"].append(data.oMf[frame].translation.copy())
        rows["rotation"].append(data.oMf[frame].rotation.copy())
        rows["bias"].append(pin.getFrameClassicalAcceleration(model, data, frame, aligned).vector)
        pin.computeJointJacobians(model, data, qk)
        rows["jacobian"].append(pin.getFrameJacobian(model, data, frame, aligned))
        G = pin.computeGeneralizedGravity(model, data, qk).copy()
        rows["G"].append(G)
        rows["E"].append(pin.rnea(model, data, qk, dq[k], ddq[k]) - G)
        rows["A"].append(pin.rnea(model, data, qk, np.zeros(model.nv), dq[k]) - G)
    ours = poses | {"bias": bias, "E": terms["E"], "G": terms["G"], "A": terms["A"]}
    for key, theirs in rows.items():
        atol = TOLERANCE * (1 + np.max(np.abs(theirs)))
        np.testing.assert_allclose(ours[key], np.array(theirs), rtol=0, atol=atol, err_msg=f"{name} {key}")


def test_efforts_and_limits_come_from_the_file(tmp_path):
    path = single_arm_cell(tmp_path, *CASES["ur5"], 6)
    description = yaml.safe_load(path.read_text())
    del description["robots"][0]["torque"]
    path.write_text(yaml.safe_dump(description))
    robot = casadi_cell(path).robots[0]
    np.testing.assert_array_equal(robot.torque_upper, [150, 150, 150, 28, 28, 28])
    np.testing.assert_allclose(robot.position_upper, [2 * np.pi, 2 * np.pi, np.pi, 2 * np.pi, 2 * np.pi, 2 * np.pi])
    np.testing.assert_allclose(robot.velocity_limit, [3.15, 3.15, 3.15, 3.2, 3.2, 3.2])


def test_two_arms_of_one_urdf_form_a_cell(tmp_path):
    """Baxter: both chains of one file, redundant arms, wrench form only."""
    reference, _ = CASES["baxter left"]
    robots = [
        {
            "name": side,
            "urdf": str(ROBOTS / reference),
            "base_link": "torso",
            "tip_link": f"{side}_gripper",
            "posture": [0.0] * 7,
            "torque": [50.0] * 7,
        }
        for side in ("left", "right")
    ]
    cell = {
        "name": "baxter",
        "gravity": [0, 0, -9.81],
        "object": {"mass": 1.0, "inertia": [0.01, 0.01, 0.01]},
        "robots": robots,
    }
    (tmp_path / "cell.yaml").write_text(yaml.safe_dump(cell), encoding="utf-8")
    loaded = casadi_cell(tmp_path / "cell.yaml")
    assert [len(robot.joints) for robot in loaded.robots] == [7, 7]
    assert "torque_form" not in loaded.functions
    assert "geometric_stiffness" in loaded.functions

"""Kinematics and dynamics of arms against Pinocchio: random chains, and URDFs that people really have."""

import numpy as np
import pinocchio as pin
import pytest
from casadi_cells import casadi_cell
from published_robots import CASES, single_arm_cell, urdf_path
from random_cells import chain_model, configuration, spatial_cell
from shipped_cells import cell_of_arms

STATES = 100
TOLERANCE = 1e-10  # relative; both sides are exact recursions, 1e-13 is typical
ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


def close(ours, theirs):
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=TOLERANCE * (1 + np.max(np.abs(theirs))))


def assert_equals_pinocchio(cell, models, bases, tip):
    """Every term of every arm at random states; models have gravity in base axes."""
    joints = sum(len(robot.joints) for robot in cell.robots)
    rng = np.random.default_rng(11)
    q, dq, ddq = rng.uniform(-2, 2, (3, STATES, joints))
    inputs = {
        "q": q,
        "dq": dq,
        "ddq": ddq,
        "object_rotation": np.array([pin.exp3(rng.normal(size=3)) for _ in range(STATES)]),
        "object_twist": rng.normal(size=(STATES, 6)),
        "object_acceleration": rng.normal(size=(STATES, 6)),
        "load": cell.load,
    }
    kinematics, dynamics, terms = (cell.functions(name, STATES, inputs) for name in ("kinematics", "dynamics", "terms"))
    bias = cell.functions("bias_acceleration", STATES, inputs)["bias_acceleration"].reshape(STATES, 6, -1)
    position = kinematics["position"].reshape(STATES, 3, -1)
    for index, (place, model, base) in enumerate(zip(cell.joint_slices.values(), models, bases, strict=True)):
        data, frame = model.createData(), model.getFrameId(tip)
        for k in range(STATES):
            qk, vk, ak = configuration(model, q[k, place]), dq[k, place], ddq[k, place]
            pin.forwardKinematics(model, data, qk, vk, np.zeros_like(vk))
            pin.updateFramePlacements(model, data)
            at = base * data.oMf[frame]
            close(position[k, :, index], at.translation)
            close(kinematics["rotation"][k, :, 3 * index : 3 * index + 3], at.rotation)
            close(bias[k, :, index], pin.getFrameClassicalAcceleration(model, data, frame, ALIGNED).vector)
            pin.computeJointJacobians(model, data, qk)
            J = pin.getFrameJacobian(model, data, frame, ALIGNED)
            close(kinematics["jacobian"][k][:, place], J)
            close(terms["J"][k][:, place], J)
            G = pin.computeGeneralizedGravity(model, data, qk).copy()
            D = pin.crba(model, data, qk)
            D = np.triu(D) + np.triu(D, 1).T
            close(dynamics["mass_matrix"][k][place, place], D)
            close(dynamics["gravity_torque"][k, place], G)
            close(terms["G"][k, place], G)
            close(terms["E"][k, place], pin.rnea(model, data, qk, vk, ak) - G)
            close(dynamics["coriolis_torque"][k, place], pin.rnea(model, data, qk, vk, np.zeros_like(vk)) - G)
            close(terms["A"][k, place], D @ vk)


@pytest.mark.quick
def test_every_term_of_random_arms_equals_pinocchio(tmp_path):
    path, description = spatial_cell(tmp_path, seed=7)
    models, bases = [], []
    for index, robot in enumerate(description["robots"]):
        bases.append(pin.SE3(pin.rpy.rpyToMatrix(*robot["base"]["rpy"]), np.array(robot["base"]["xyz"])))
        models.append(chain_model(tmp_path / f"arm{index}.urdf"))
        models[-1].gravity.linear = bases[-1].rotation.T @ np.array(description["gravity"])
    assert_equals_pinocchio(casadi_cell(path), models, bases, "tip")


@pytest.mark.parametrize("name", CASES)
def test_terms_of_published_robots_equal_pinocchio(name, tmp_path):
    reference, tip = CASES[name]
    model = chain_model(urdf_path(reference), tip)
    model.gravity.linear = np.array([0.3, -0.2, -9.81])
    cell = casadi_cell(single_arm_cell(tmp_path, reference, tip, model.nv))
    assert list(cell.robots[0].joints) == list(model.names)[1:]
    assert_equals_pinocchio(cell, [model], [pin.SE3.Identity()], tip)


def test_a_chain_inside_a_larger_tree_starts_at_its_base_link(tmp_path):
    """From l0 on, the joints before it and their links play no part; what hangs beyond the tip still has weight."""
    spatial_cell(tmp_path, seed=7)
    urdf = tmp_path / "arm0.urdf"
    arm = {"name": "arm", "urdf": str(urdf), "base_link": "l0", "tip_link": "l3", "posture": [0.0] * 3}
    loaded = casadi_cell(cell_of_arms(tmp_path, arm))
    assert loaded.robots[0].joints == ("j1", "j2", "j3")
    assert "torque_form" not in loaded.generated.manifest.functions  # three joints, six wrench components
    full = pin.buildModelFromUrdf(str(urdf))
    lock = [full.getJointId(name) for name in ("j0", "j4", "j5", "to_finger")]
    model = pin.buildReducedModel(full, lock, pin.neutral(full))
    base = full.createData()
    pin.framesForwardKinematics(full, base, pin.neutral(full))
    model.gravity.linear = base.oMf[full.getFrameId("l0")].rotation @ np.array([0, 0, -9.81])
    q = np.array([0.3, 0.2, -0.7])
    theirs = pin.computeGeneralizedGravity(model, model.createData(), configuration(model, q))
    close(loaded.functions("dynamics", 1, {"q": q[None], "dq": np.zeros((1, 3))})["gravity_torque"][0], theirs)

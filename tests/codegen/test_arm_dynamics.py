"""Kinematics and dynamics of spatial arms against Pinocchio and finite differences."""

import numpy as np
import pinocchio as pin
import pytest
import yaml
from casadi_cells import casadi_cell
from random_cells import chain_model, configuration, spatial_cell

STATES = 200
TOLERANCE = 1e-10  # relative; both sides are exact recursions, 1e-13 is typical
DIFFERENCE_STEP = 1e-6
DIFFERENCE_TOLERANCE = 1e-7  # central differences of O(1) quantities: step² plus rounding over step


@pytest.fixture(scope="module")
def spatial(tmp_path_factory):
    folder = tmp_path_factory.mktemp("spatial")
    path, description = spatial_cell(folder, seed=7)
    return casadi_cell(path), description, folder


@pytest.fixture(scope="module")
def states(spatial):
    cell = spatial[0]
    joints = sum(len(robot.joints) for robot in cell.robots)
    rng = np.random.default_rng(11)
    return tuple(rng.uniform(-2, 2, (STATES, joints)) for _ in range(3))


def pinocchio_arm(folder, index, gravity, base):
    model = chain_model(folder / f"arm{index}.urdf")
    model.gravity.linear = base.rotation.T @ gravity
    return model


def close(ours, theirs):
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=TOLERANCE * (1 + np.max(np.abs(theirs))))


@pytest.mark.quick
def test_every_term_equals_pinocchio(spatial, states):
    cell, description, folder = spatial
    q, dq, ddq = states
    rng = np.random.default_rng(3)
    rotation = np.array([pin.exp3(rng.normal(size=3)) for _ in range(STATES)])
    inputs = {
        "q": q,
        "dq": dq,
        "ddq": ddq,
        "object_rotation": rotation,
        "object_twist": rng.normal(size=(STATES, 6)),
        "object_acceleration": rng.normal(size=(STATES, 6)),
        "load": cell.load,
    }
    kinematics = cell.functions("kinematics", STATES, inputs)
    bias = cell.functions("bias_acceleration", STATES, inputs)["bias_acceleration"]
    dynamics = cell.functions("dynamics", STATES, inputs)
    terms = cell.functions("terms", STATES, inputs)
    for index, (robot, place) in enumerate(zip(description["robots"], cell.joint_slices.values(), strict=True)):
        base = pin.SE3(pin.rpy.rpyToMatrix(*robot["base"]["rpy"]), np.array(robot["base"]["xyz"]))
        model = pinocchio_arm(folder, index, np.array(description["gravity"]), base)
        data, frame = model.createData(), model.getFrameId("tip")
        for k in range(STATES):
            qk, vk, ak = configuration(model, q[k, place]), dq[k, place], ddq[k, place]
            pin.forwardKinematics(model, data, qk, vk, np.zeros_like(vk))
            pin.updateFramePlacements(model, data)
            tip = base * data.oMf[frame]
            close(kinematics["position"][k, :, index], tip.translation)
            close(kinematics["rotation"][k, :, 3 * index : 3 * index + 3], tip.rotation)
            aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            close(bias[k, :, index], pin.getFrameClassicalAcceleration(model, data, frame, aligned).vector)
            pin.computeJointJacobians(model, data, qk)
            J = pin.getFrameJacobian(model, data, frame, aligned)
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


def test_jacobian_and_bias_are_derivatives_of_the_pose(spatial, states):
    cell = spatial[0]
    q, dq, _ = (state[:20] for state in states)
    count = len(q)

    def pose(at):
        return cell.functions("kinematics", count, {"q": at})

    here, ahead, behind = pose(q), pose(q + DIFFERENCE_STEP * dq), pose(q - DIFFERENCE_STEP * dq)
    bias = cell.functions("bias_acceleration", count, {"q": q, "dq": dq})["bias_acceleration"]
    for index, (robot, place) in enumerate(zip(cell.robots, cell.joint_slices.values(), strict=True)):
        R_base_world = robot.T_world_base.R.T
        part = slice(3 * index, 3 * index + 3)
        moved = (ahead["position"] - behind["position"])[:, :, index] / (2 * DIFFERENCE_STEP)
        turned = np.array(
            [
                pin.log3(a @ b.T)
                for a, b in zip(ahead["rotation"][:, :, part], behind["rotation"][:, :, part], strict=True)
            ]
        ) / (2 * DIFFERENCE_STEP)
        rate = np.einsum("nwj,nj->nw", here["jacobian"][:, :, place], dq[:, place])
        np.testing.assert_allclose(rate[:, :3], moved @ R_base_world.T, atol=DIFFERENCE_TOLERANCE)
        np.testing.assert_allclose(rate[:, 3:], turned @ R_base_world.T, atol=DIFFERENCE_TOLERANCE)
        J_change = (ahead["jacobian"] - behind["jacobian"])[:, :, place] / (2 * DIFFERENCE_STEP)
        np.testing.assert_allclose(
            bias[:, :, index], np.einsum("nwj,nj->nw", J_change, dq[:, place]), atol=100 * DIFFERENCE_TOLERANCE
        )


def test_gravity_is_the_slope_of_potential_energy_and_power_balances(spatial, states):
    """d/dt (kinetic + potential energy) = q̇ᵀ (E + G) along any motion: couples D, C and G."""
    cell = spatial[0]
    q, dq, ddq = (state[:50] for state in states)
    count = len(q)

    def kinetic(t):
        position, velocity = q + t * dq + t * t / 2 * ddq, dq + t * ddq
        D = cell.functions("dynamics", count, {"q": position, "dq": velocity})["mass_matrix"]
        return np.einsum("ni,nij,nj->n", velocity, D, velocity) / 2

    change = (kinetic(DIFFERENCE_STEP) - kinetic(-DIFFERENCE_STEP)) / (2 * DIFFERENCE_STEP)
    still = {
        "object_rotation": np.broadcast_to(np.eye(3), (count, 3, 3)),
        "object_twist": np.zeros(6),
        "object_acceleration": np.zeros(6),
        "load": cell.load,
    }
    E = cell.functions("terms", count, {"q": q, "dq": dq, "ddq": ddq} | still)["E"]
    power = np.sum(dq * E, axis=1)
    np.testing.assert_allclose(change, power, rtol=1e-6, atol=1e-6 * np.max(np.abs(power)))


def test_a_chain_inside_a_larger_tree_starts_at_its_base_link(spatial, tmp_path):
    """From l0 on, the joints before it and their links play no part."""
    folder = spatial[2]
    cell = {
        "name": "part",
        "gravity": [0, 0, -9.81],
        "object": {"mass": 1.0, "inertia": [0.1, 0.1, 0.1]},
        "robots": [
            {
                "name": "arm",
                "urdf": str(folder / "arm0.urdf"),
                "base_link": "l0",
                "tip_link": "l3",
                "posture": [0.0] * 3,
            }
        ],
    }
    (tmp_path / "cell.yaml").write_text(yaml.safe_dump(cell), encoding="utf-8")
    loaded = casadi_cell(tmp_path / "cell.yaml")
    assert loaded.robots[0].joints == ("j1", "j2", "j3")
    assert "torque_form" not in loaded.functions  # three joints, six wrench components
    # what hangs beyond the tip still has weight: compare with the whole arm's last columns
    full = pin.buildModelFromUrdf(str(folder / "arm0.urdf"))
    lock = [full.getJointId(name) for name in ("j0", "j4", "j5", "to_finger")]
    model = pin.buildReducedModel(full, lock, pin.neutral(full))
    data = model.createData()
    base = full.createData()
    pin.framesForwardKinematics(full, base, pin.neutral(full))
    model.gravity.linear = base.oMf[full.getFrameId("l0")].rotation @ np.array([0, 0, -9.81])
    q = np.array([0.3, 0.2, -0.7])
    theirs = pin.computeGeneralizedGravity(model, data, configuration(model, q))
    ours = loaded.functions("dynamics", 1, {"q": q[None], "dq": np.zeros((1, 3))})["gravity_torque"][0]
    close(ours, theirs)

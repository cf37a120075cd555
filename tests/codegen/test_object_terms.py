"""P, S, Q, B, L and the affine maps of a spatial cell: finite differences, virtual work, definitions."""

import numpy as np
import pytest
from casadi_cells import casadi_cell
from random_cells import spatial_cell
from scipy.spatial.transform import Rotation

SAMPLES = 50
STEP = 1e-6
DIFFERENCE_TOLERANCE = 1e-7
TOLERANCE = 1e-10


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    folder = tmp_path_factory.mktemp("three")
    return casadi_cell(spatial_cell(folder, seed=3, joints=(6, 6, 6))[0])


@pytest.fixture(scope="module")
def inputs(cell):
    rng = np.random.default_rng(5)
    joints = sum(len(robot.joints) for robot in cell.robots)
    return {
        "q": rng.uniform(-2, 2, (SAMPLES, joints)),
        "dq": rng.normal(size=(SAMPLES, joints)),
        "ddq": rng.normal(size=(SAMPLES, joints)),
        "object_rotation": Rotation.random(SAMPLES, rng=rng).as_matrix(),
        "object_twist": rng.normal(size=(SAMPLES, 6)),
        "object_acceleration": rng.normal(size=(SAMPLES, 6)),
        "load": cell.load,
    }


@pytest.fixture(scope="module")
def terms(cell, inputs):
    return cell.functions("terms", SAMPLES, inputs)


@pytest.mark.quick
def test_object_wrench_is_the_rate_of_momentum_under_any_warp(cell, inputs, terms):
    """P ṙ² + S r̈ = d/dt [m v; I_w ω] for the motion played with rate ṙ and acceleration r̈."""
    rate, acceleration = 1.3, -0.7
    R, twist, change = (inputs[key] for key in ("object_rotation", "object_twist", "object_acceleration"))
    v, w = rate * twist[:, :3], rate * twist[:, 3:]
    dv, dw = (rate**2 * change[:, part] + acceleration * twist[:, part] for part in (slice(0, 3), slice(3, 6)))

    def momentum(t):
        # the body turns by w t + dw t²/2 up to third order
        turned = Rotation.from_rotvec(w * t + dw * t * t / 2).as_matrix() @ R
        I_w = turned @ cell.inertia @ turned.transpose(0, 2, 1)
        return np.concatenate([cell.mass * (v + t * dv), np.einsum("nij,nj->ni", I_w, w + t * dw)], axis=1)

    by_difference = (momentum(STEP) - momentum(-STEP)) / (2 * STEP)
    np.testing.assert_allclose(
        terms["P"] * rate**2 + terms["S"] * acceleration, by_difference, atol=DIFFERENCE_TOLERANCE
    )


def test_grasp_maps_do_the_same_virtual_work(cell, inputs, terms):
    """F_i · (velocity of contact i in base axes) = (B_i F_i) · (object twist), for every wrench and twist."""
    rng = np.random.default_rng(8)
    twist = rng.normal(size=(SAMPLES, 6))
    for index, robot in enumerate(cell.robots):
        F = rng.normal(size=(SAMPLES, 6))
        r = inputs["object_rotation"] @ robot.T_object_tip.p
        R = robot.T_world_base.R
        contact = np.concatenate([(twist[:, :3] + np.cross(twist[:, 3:], r)) @ R, twist[:, 3:] @ R], axis=1)
        B = terms["B"][:, :, 6 * index : 6 * index + 6]
        on_object = np.einsum("nij,nj->ni", B, F)
        np.testing.assert_allclose(np.sum(F * contact, 1), np.sum(on_object * twist, 1), atol=TOLERANCE)


def test_forms_follow_their_definitions(cell, inputs, terms):
    """Both forms: any unknowns give torques and wrenches that satisfy (13) and (20)."""
    rng = np.random.default_rng(9)
    c2 = 1.7
    for form in ("wrench_form", "torque_form"):
        maps = cell.functions(form, SAMPLES, inputs)
        k = maps["torque_map"].shape[2]
        x = rng.normal(size=(SAMPLES, k))
        x[:, -1] = c2
        if form == "torque_form":  # put x on the balance
            rows, rhs = maps["equality_map"], maps["equality_rhs"]
            gap = rhs - np.einsum("nek,nk->ne", rows, x)
            x[:, :-1] += np.einsum("nke,ne->nk", np.linalg.pinv(rows[:, :, :-1]), gap)
        tau = np.einsum("nmk,nk->nm", maps["torque_map"], x) + maps["torque_offset"]
        F = np.einsum("nmk,nk->nm", maps["wrench_map"], x) + maps["wrench_offset"]
        scale = 1 + np.max(np.abs(tau), axis=1) + np.max(np.abs(F), axis=1)
        balance = np.einsum("nij,nj->ni", terms["B"], F) - c2 * terms["P"] - terms["Q"]
        assert np.max(np.abs(balance) / scale[:, None]) < TOLERANCE, form
        arms = tau - c2 * terms["E"] - terms["G"]
        for name, joints in cell.joint_slices.items():
            J, part = terms["J"][:, :, joints], F[:, cell.wrench_slices[name]]
            arms[:, joints] -= np.einsum("nwj,nw->nj", J, part)
        assert np.max(np.abs(arms) / scale[:, None]) < TOLERANCE, form


def test_fixed_distribution_carries_the_object_for_any_shares(cell, inputs, terms):
    shares = np.array([0.5, 0.2, 0.3])
    maps = cell.functions("fixed_distribution", SAMPLES, inputs | {"shares": shares, "internal_wrench": np.zeros(18)})
    for of_wrench, expected in (("wrench_map", "P"), ("wrench_offset", "Q")):
        carried = np.einsum("nij,nj->ni", terms["B"], maps[of_wrench].reshape(SAMPLES, 18))
        np.testing.assert_allclose(carried, terms[expected], atol=TOLERANCE)
    forces = maps["wrench_offset"].reshape(SAMPLES, 3, 6)[:, :, :3]
    for index, robot in enumerate(cell.robots):
        world = forces[:, index] @ robot.T_world_base.R.T
        np.testing.assert_allclose(world, shares[index] * terms["Q"][:, :3], atol=TOLERANCE)

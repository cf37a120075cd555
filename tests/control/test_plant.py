"""The simulated cell against the equations of the product: two formulations of the same dynamics."""

from dataclasses import replace

import numpy as np
import pytest
from cell_bank import drawn_until, random_spatial_cell
from random_motors import equipped
from shipped_cells import DATA, changed_cell

import mrts
from mrts.control.controller import PlantErrors
from mrts.control.plant import Plant, mujoco

SAME_TORQUE = 2e-11
"""[N m]; rounding of a thousand operations on terms of some hundred."""

NONE = PlantErrors(mass=0.0, friction_error=0.0)

MOTIONS = {
    "dual_ur5": "lift_and_turn.yaml",
    "planar_dual_arm": "lift.yaml",
    "redundant": "lift.yaml",
    "squeeze": "lift_and_turn.yaml",
    "three_arms": "lift_and_turn.yaml",
    "upper_body": "lift.yaml",
}


def torques_of_mujoco(plant, done):
    """What MuJoCo's inverse dynamics asks of the joints, with the plan's wrenches pushed back, and of the object."""
    model, data, given = plant.model, plant.data, done.motion.object
    torques, balance = [], []
    for k, R in enumerate(given.rotation):
        plant.set_state(done.q[k], done.dq[k], given.position[k], R, done.c * given.twist[k])
        data.qacc[plant.v_index] = done.ddq[k]
        a, dw = np.split(done.c2 * given.acceleration[k], 2)
        data.qacc[:6] = np.concatenate([a, R.T @ dw])
        mujoco.mj_inverse(model, data)
        needed = data.qfrc_inverse + data.qfrc_constraint  # without dry friction
        for robot, hand in zip(plant.cell.robots, plant.hands, strict=True):
            six, J = np.zeros(6), np.zeros((2, 3, model.nv))
            six[plant.cell.wrench_rows] = done.wrench[k, plant.cell.wrench_slices[robot.name]]
            force, moment = (robot.T_world_base.R @ part for part in np.split(six, 2))
            mujoco.mj_jacSite(model, data, *J, hand)
            needed[plant.v_index] += (J[0].T @ force + J[1].T @ moment)[plant.v_index]
            held = model.site(f"{robot.name}/held").id
            mujoco.mj_jacSite(model, data, *J, held)
            needed[:6] -= (J[0].T @ force + J[1].T @ moment)[:6]
        torques.append(needed[plant.v_index])
        balance.append(needed[:6])
    return np.array(torques), np.array(balance)


VISCOUS = 0.3


def compare(cell, motion):
    cell = equipped(cell, armature=0.1, coulomb=0.2, viscous=VISCOUS)
    done = mrts.scale(cell, motion).trajectory
    torque, balance = torques_of_mujoco(Plant(cell, NONE, 0.0, 1e-5), done)
    dry = done.friction - VISCOUS * done.dq
    print("torques", np.max(np.abs(torque + dry - done.torque)), "object", np.max(np.abs(balance)))
    np.testing.assert_allclose(torque + dry, done.torque, atol=SAME_TORQUE)
    np.testing.assert_allclose(balance, 0.0, atol=SAME_TORQUE)


@pytest.mark.parametrize("name", MOTIONS)
def test_torques_are_those_of_the_plan(name):
    compare(mrts.load_cell(DATA / name / "cell.yaml"), mrts.load_motion(DATA / name / MOTIONS[name]))


def test_inertias_are_those_that_lenient_cells_take(tmp_path):
    """MuJoCo itself refuses such a body."""
    text = (DATA / "planar_dual_arm" / "planar_arm.urdf").read_text()
    (tmp_path / "arm.urdf").write_text(text.replace('izz="0.42916666666666664"', 'izz="4.2"'))

    def lenient(keys):
        keys["inertia"] = "lenient"
        keys["robots"][0]["urdf"] = str(tmp_path / "arm.urdf")

    cell = mrts.load_cell(changed_cell(tmp_path, lenient))
    compare(cell, mrts.load_motion(DATA / "planar_dual_arm" / "lift.yaml"))


def test_sliding_joints_and_random_placements_are_those_of_the_plan(tmp_path):
    def done(case):
        return True if mrts.scale(case.cell, case.motion).trajectory else None

    rng = np.random.default_rng(3)
    case, _ = drawn_until(done, lambda: random_spatial_cell(rng, tmp_path, 2))
    assert "prismatic" in case.cell.robots[0].joint_types
    compare(mrts.load_cell(case.cell_file), case.motion)


def test_a_load_with_first_moments_is_carried(dual_ur5):
    cell = dual_ur5.with_load([8.0, 0.4, -0.2, 0.1, 0.3, 0.4, 0.5, 0.02, 0.01, -0.03])
    compare(cell, mrts.load_motion(DATA / "dual_ur5" / "lift_and_turn.yaml"))


def test_a_cell_without_its_urdfs_is_refused(planar_cell):
    with pytest.raises(mrts.InputError, match=planar_cell.name):
        Plant(replace(planar_cell, folder=None), NONE, 0.0, 1e-5)


def test_a_urdf_that_was_changed_since_is_refused(tmp_path):
    (tmp_path / "arm.urdf").write_text((DATA / "planar_dual_arm" / "planar_arm.urdf").read_text())
    cell = mrts.load_cell(
        changed_cell(tmp_path, lambda keys: keys["robots"][0].update(urdf=str(tmp_path / "arm.urdf")))
    )
    (tmp_path / "arm.urdf").write_text((tmp_path / "arm.urdf").read_text() + "\n")
    with pytest.raises(mrts.InputError, check=lambda error: error.where == str(tmp_path / "arm.urdf")):
        Plant(cell, NONE, 0.0, 1e-5)

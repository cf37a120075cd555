"""Where things are drawn, against the generated kinematics and closed forms."""

import numpy as np
import pytest
from conftest import DATA

import mrts
from mrts.scene.cell_shapes import contact_forces, joint_points, name_place, object_box, shares_base

pytestmark = pytest.mark.quick

SAME_PLACE = 1e-12
"""[m]; the same transforms in another order."""


@pytest.mark.parametrize("files", [("planar_dual_arm", "lift"), ("dual_ur5", "lift_and_turn")])
def test_a_drawn_arm_ends_at_its_grasp(files):
    cell = mrts.load_cell(DATA.parent / files[0] / "cell.yaml")
    motion = mrts.follow_object(cell, mrts.load_motion(DATA.parent / files[0] / f"{files[1]}.yaml"))
    for robot, joints in zip(cell.robots, cell.joint_slices.values(), strict=True):
        line = joint_points(robot, motion.q[:, joints])
        assert line.shape == (motion.samples, len(robot.joints) + 2, 3)
        np.testing.assert_allclose(line[:, 0], np.tile(robot.T_world_base.p, (motion.samples, 1)))
        grasp = motion.object.position + motion.object.rotation @ robot.T_object_tip.p
        np.testing.assert_allclose(line[:, -1], grasp, atol=1e-8)
        lengths = np.linalg.norm(np.diff(line, axis=1), axis=2)
        np.testing.assert_allclose(lengths, np.tile(lengths[0], (motion.samples, 1)), atol=SAME_PLACE)


def test_names_of_arms_on_one_torso_stand_apart(dual_ur5):
    for robot in dual_ur5.robots:
        assert not shares_base(dual_ur5, robot)
        np.testing.assert_array_equal(name_place(dual_ur5, robot), robot.T_world_base.p)
    machine = mrts.load_cell(DATA.parent / "upper_body" / "cell.yaml")
    for robot in machine.robots:
        assert shares_base(machine, robot)
        shoulder = joint_points(robot, robot.posture[None])[0, 1]
        np.testing.assert_allclose(name_place(machine, robot), shoulder, atol=SAME_PLACE)


def test_the_box_has_the_objects_inertia(dual_ur5):
    sides = object_box(dual_ur5)
    expected = dual_ur5.mass / 12 * (np.sum(sides**2) - sides**2)
    np.testing.assert_allclose(expected, np.diag(dual_ur5.inertia), rtol=1e-9)


def test_drawn_forces_carry_the_object(dual_ur5):
    result = mrts.scale(dual_ur5, mrts.load_motion(DATA.parent / "dual_ur5" / "lift_and_turn.yaml"))
    given, done = result.motion.object, result.trajectory
    parts = [
        contact_forces(dual_ur5, robot, given.position, given.rotation, result.wrench[robot.name])
        for robot in dual_ur5.robots
    ]
    acceleration = done.c2 * given.acceleration[:, :3]
    np.testing.assert_allclose(
        sum(part.force for part in parts), dual_ur5.mass * (acceleration - dual_ur5.gravity), atol=1e-8
    )

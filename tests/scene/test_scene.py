"""Where things are drawn: against yourdfpy, the generated kinematics and closed forms; cameras that see all."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import trimesh
import yourdfpy
from casadi_cells import casadi_cell
from cell_bank import random_planar_cell, random_spatial_cell
from conftest import DATA
from published_robots import ROBOTS
from shipped_cells import cell_of_arms

import mrts
from mrts.cell.generation import urdf_of
from mrts.following.bodies import body_poses
from mrts.plots.card import answer_card
from mrts.scene.arm_meshes import arm_meshes, drawn_arms, name_place, shares_base
from mrts.scene.cell_view import FIELD_OF_VIEW, CellView, look_at
from mrts.scene.held_body import held_body, object_box
from mrts.scene.scene import OVER_LIMIT, SHARED_BASE, Scene, arm_colour, arm_line

SAME_PLACE = 1e-9
"""[m]; meshes pass through single precision nowhere, but yourdfpy's angles are its own."""

ASPECT = 4 / 3

MOST_SPARE = 0.2
"""Free at the narrower sides, as a share of the picture: a camera stands a little farther away than it must."""


def vertices_of(path, first, q):
    """A vertex of every visual in the axes of a link, by yourdfpy's own kinematics; the model too."""
    model = yourdfpy.URDF.load(
        str(path), filename_handler=partial(yourdfpy.filename_handler_magic, dir=str(path.parent))
    )
    model.update_cfg(q)
    found = []
    for node in model.scene.graph.nodes_geometry:
        pose, name = model.scene.graph.get(node, first or model.base_link)
        found.append(pose[:3, :3] @ model.scene.geometry[name].vertices[0] + pose[:3, 3])
    return np.array(found), model


@pytest.mark.parametrize(
    ("urdf", "base_link", "tip_link", "joints"),
    [
        ("panda_description/urdf/panda.urdf", "panda_link0", "panda_hand_tcp", 7),
        ("baxter_description/urdf/baxter.urdf", "torso", "left_gripper", 7),
        ("baxter_description/urdf/baxter.urdf", "left_upper_shoulder", "left_wrist", 6),
    ],
)
def test_meshes_stand_where_yourdfpy_puts_them(urdf, base_link, tip_link, joints, tmp_path):
    """Ours turns the meshes at zero by the manifest's axes."""
    robot = {"name": "arm", "urdf": str(ROBOTS / urdf), "base_link": base_link, "tip_link": tip_link}
    robot |= {"posture": [0.1] * joints, "torque": [100.0] * joints, "base": {"xyz": [1, 2, 3], "rpy": [0.3, 0.2, 0.1]}}
    cell = casadi_cell(cell_of_arms(tmp_path, robot))
    (robot,) = cell.robots
    path, base = urdf_of(robot, tmp_path), robot.source.base_link
    found = arm_meshes(path, base, robot.joints)
    assert {body for body, _ in found} >= set(range(1, joints - 1))
    q = np.random.default_rng(3).uniform(-1, 1, joints)
    theirs, model = vertices_of(path, base, dict(zip(robot.joints, q, strict=True)))
    R, p = body_poses(robot, q[None])
    T = robot.T_world_base
    for body, mesh in found:
        ours = T.R.T @ (R[0, body] @ mesh.vertices[0] + p[0, body] - T.p)
        assert np.min(np.linalg.norm(theirs - ours, axis=1)) < SAME_PLACE
    tip = model.get_transform(tip_link, base)[:3, 3]
    np.testing.assert_allclose(arm_line(robot, R, p)[0, -1], T.R @ tip + T.p, atol=SAME_PLACE)


def test_a_held_joint_is_drawn_where_it_stands_and_another_arm_not_at_all():
    """The right arm hangs on Baxter's torso; held bent, its meshes stand with the base, not left out or at zero."""
    path = ROBOTS / "baxter_description/urdf/baxter.urdf"
    joints = tuple(f"left_{joint}" for joint in ("s0", "s1", "e0", "e1", "w0", "w1", "w2"))
    alone = arm_meshes(path, "torso", joints)
    assert {body for body, _ in alone} == set(range(8))
    across = np.concatenate([mesh.vertices for _, mesh in alone])[:, 1]
    assert np.max(across) > 0.8
    assert np.min(across) > -0.6  # the right arm would reach as far to the other side
    held = {"left_s0": 0.7, "right_s0": 0.4, "right_s1": -0.3}
    found = [mesh.vertices[0] for _, mesh in arm_meshes(path, "torso", joints[1:], held)]
    theirs, _ = vertices_of(path, "torso", held)
    assert min(vertex[1] for vertex in found) < -0.3  # the right upper arm
    assert max(np.min(np.linalg.norm(theirs - vertex, axis=1)) for vertex in found) < SAME_PLACE


def test_what_two_arms_stand_on_has_the_colour_of_neither_and_their_names_stand_apart(dual_ur5):
    path = DATA.parent / "upper_body" / "cell.yaml"
    machine = mrts.load_cell(path)
    for index, parts in enumerate(drawn_arms(machine, pytest.fail)):
        assert {part.colour() for part in parts if part.body == 0} == {SHARED_BASE}
        assert {part.colour() for part in parts if part.body} == {arm_colour(index)}
    for robot in machine.robots:
        assert shares_base(machine, robot)
        shoulder = arm_line(robot, *body_poses(robot, robot.posture[None]))[0, 1]
        np.testing.assert_allclose(name_place(machine, robot), shoulder, atol=1e-12)
    for robot in dual_ur5.robots:
        assert not shares_base(dual_ur5, robot)
        np.testing.assert_array_equal(name_place(dual_ur5, robot), robot.T_world_base.p)


def test_the_joint_that_decides_stands_out(dual_ur5, turned):
    """The range of this cell ends where the right arm's fifth joint reaches its velocity limit."""
    found = answer_card(turned).deciding
    (row,) = turned.range.upper.rows
    assert (found.name, found.sample) == (row.name, turned.range.upper.sample)
    assert found.share == pytest.approx(1.0)
    slow = mrts.scale(dual_ur5, turned.motion.object, 1.0)
    assert answer_card(slow).deciding.share == pytest.approx(max(use.share for use in slow.trajectory.limit_uses))
    left, right = drawn_arms(dual_ur5, pytest.fail)
    assert [found.body(robot) for robot in dual_ur5.robots] == [None, 5]
    assert {part.body for part in right if part.colour(5) == OVER_LIMIT} == {5}
    assert all(part.colour(None) != OVER_LIMIT for part in (*left, *right))


@pytest.mark.quick
def test_a_drawn_arm_ends_at_its_grasp_and_forces_carry_the_object(dual_ur5, turned):
    cell, motion, given = dual_ur5, turned.motion, turned.motion.object
    scene = Scene.of(turned.trajectory)
    for robot, line in zip(cell.robots, scene.lines, strict=True):
        assert line.shape == (motion.samples, len(robot.joints) + 2, 3)
        np.testing.assert_allclose(line[:, 0], np.tile(robot.T_world_base.p, (motion.samples, 1)))
        grasp = given.position + given.rotation @ robot.T_object_tip.p
        np.testing.assert_allclose(line[:, -1], grasp, atol=1e-8)
        lengths = np.linalg.norm(np.diff(line, axis=1), axis=2)
        np.testing.assert_allclose(lengths, np.tile(lengths[0], (motion.samples, 1)), atol=1e-12)
    total = np.sum(scene.contacts[1], axis=1)
    acceleration = turned.trajectory.c2 * given.acceleration[:, :3]
    np.testing.assert_allclose(total, cell.mass * (acceleration - cell.gravity), atol=1e-8)


def test_the_body_is_closed_has_the_inertia_and_spans_the_grasps(dual_ur5):
    """Each contact lies at the drawn body, even where the inertia says nothing of a handle there."""
    sides = object_box(dual_ur5)
    expected = dual_ur5.mass / 12 * (np.sum(sides**2) - sides**2)
    np.testing.assert_allclose(expected, np.diag(dual_ur5.inertia), rtol=1e-9)
    bare = replace(dual_ur5, object_shape=None)
    far = bare.with_values({"robots.left.grasp.xyz": [-0.6, 0.1, 0.3], "robots.right.grasp.xyz": [0.05, 0.02, 0.01]})
    for cell in (dual_ur5, bare, far):
        vertices, faces = held_body(cell)
        mesh = trimesh.Trimesh(vertices, faces, process=False)
        assert mesh.is_watertight
        assert mesh.volume > 0
        contacts = np.array([robot.T_object_tip.p for robot in cell.robots])
        _, distance, _ = trimesh.proximity.closest_point(mesh, contacts)
        assert np.max(distance) < 0.1 * np.ptp(vertices)


@pytest.mark.parametrize(("make", "arms"), [(random_planar_cell, 3), (random_spatial_cell, 1)])
def test_the_cell_is_in_the_picture_and_upright(make, arms, tmp_path):
    case = make(np.random.default_rng([9, arms]), tmp_path, arms)
    cell = case.cell
    motion = mrts.follow_object(cell, case.motion)
    given, passed = motion.object, np.zeros(motion.samples, dtype=bool)
    scene = Scene(cell, given.time, motion.q, given.position, given.rotation, passed)
    view = look_at(scene)
    np.testing.assert_allclose(view.up, -cell.gravity / np.linalg.norm(cell.gravity))
    points = np.concatenate([line.reshape(-1, 3) for line in scene.lines])
    for aspect in (0.5, 1.7, 3.0):
        seen, away, _ = in_picture(points, view.camera(aspect), aspect)
        assert np.min(away) > 0
        assert np.max(np.abs(seen)) < 1
    bases = np.array([robot.T_world_base.p for robot in cell.robots])
    above = (np.concatenate([bases, view.points]) - view.floor) @ view.up
    assert np.min(above) == pytest.approx(0, abs=1e-9)


def in_picture(points, camera, aspect=ASPECT):
    """Where points are, from -1 to 1 to either side, how far away, and the camera."""
    along = (points - camera.position) @ camera.axes.T
    return along[:, :2] / along[:, 2:] / np.tan(FIELD_OF_VIEW / 2) / [aspect, 1], along[:, 2], camera


def camera_at(points, backward):
    direction = np.array(backward) / np.linalg.norm(backward)
    return CellView(np.eye(3)[2], direction, points, np.zeros(3), 1.0).camera(ASPECT)


@pytest.mark.quick
def test_a_camera_has_all_points_in_its_picture_and_none_would_do_nearer():
    rng = np.random.default_rng(1)
    for _ in range(20):
        points = rng.normal(size=(30, 3)) * rng.uniform(0.1, 2, 3) + rng.normal(size=3)
        seen, away, camera = in_picture(points, camera_at(points, rng.normal(size=3) * [1, 1, 0.3]))
        assert np.all(away > 0)
        assert np.all(np.abs(seen) < 1)
        assert np.min((1 - np.max(np.abs(seen), axis=0)) / 2) < MOST_SPARE
        np.testing.assert_allclose(camera.axes @ camera.axes.T, np.eye(3), atol=1e-12)
        ahead = camera.target - camera.position
        np.testing.assert_allclose(ahead / np.linalg.norm(ahead), camera.axes[2], atol=1e-9)

"""The least distance of bodies along a motion: against MuJoCo, closed forms, and dense samples."""

import sys
from dataclasses import replace
from itertools import combinations

import mujoco
import numpy as np
import pytest
import trimesh
from conftest import UR5
from shipped_cells import shipped
from study_files import planar_study, write_study

import mrts
from mrts.base.formats.record import dumped
from mrts.following.clearance import RESOLUTION, SHARE, CollisionModel
from mrts.following.coordinate import coordinate
from mrts.starting.check import check
from mrts.studies.variants import solve_variants

TORSO = UR5.parent / "upper_body"

EXACT = 1e-6
"""What iterations of both libraries leave [m]."""


def described(surroundings, **of_object):
    given = shipped("dual_ur5")
    return given | {"surroundings": list(surroundings), "object": given["object"] | of_object}


def lifting(**keys):
    """Straight up from where the arms of the shipped cell begin, by 0.2 m."""
    given = {"duration": 1.0, "samples": 101, "profile": "quintic", "start": {"xyz": [0, 0.1, 0.35]}}
    return mrts.load_motion(given | {"end": {"xyz": [0, 0.1, 0.55]}} | keys)


def box(name, sides, xyz):
    return {"name": name, "box": sides, "pose": {"xyz": xyz}}


def mujoco_geoms(robot, q):
    """Type, size, place and turning in the world of an arm's collision shapes, by link, at joint positions."""
    model = mujoco.MjModel.from_xml_path(str(UR5 / "ur5_class_arm.urdf"))
    data = mujoco.MjData(model)
    data.qpos[:] = q
    mujoco.mj_kinematics(model, data)
    base = robot.T_world_base
    for at in range(model.ngeom):
        place = base.R @ data.geom_xpos[at] + base.p
        turned = base.R @ data.geom_xmat[at].reshape(3, 3)
        yield int(model.geom_bodyid[at]), (int(model.geom_type[at]), model.geom_size[at], place, turned)


def mujoco_distances(geoms, pairs):
    """Signed distances between bodies that stand in the world."""
    spec = mujoco.MjSpec()
    for kind, size, place, turned in geoms:
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, turned.ravel())
        spec.worldbody.add_geom(type=mujoco.mjtGeom(kind), size=size, pos=place, quat=quaternion)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return [mujoco.mj_geomDistance(model, data, a, b, 10.0, None) for a, b in pairs]


def test_distances_are_those_of_mujoco():
    """Arms, object and two obstacles at samples of a motion that turns; hulls, pairs and bodies found independently."""
    obstacles = [box("table", [2, 2, 0.02], [0, 0, -0.2]), box("post", [0.1, 0.1, 1.0], [0.2, 0.55, 0.4])]
    cell = mrts.Cell.from_description(described(obstacles))
    motion = coordinate(cell, mrts.load_motion(UR5 / "lift_and_turn.yaml"))
    found = mrts.clearance(cell, motion)
    for sample in (0, 37, 71, 100):
        bodies = []  # arm and number of the body, and the shape
        for arm, (robot, joints) in enumerate(zip(cell.robots, cell.joint_slices.values(), strict=True)):
            bodies += [((arm, body), geom) for body, geom in mujoco_geoms(robot, motion.q[sample, joints])]
        carried, R = motion.object.position[sample], motion.object.rotation[sample]
        bodies.append((("object", 0), (mujoco.mjtGeom.mjGEOM_BOX, np.array([0.25, 0.15, 0.05]), carried, R)))
        bodies += [
            (("room", 0), (mujoco.mjtGeom.mjGEOM_BOX, np.array(one["box"]) / 2, one["pose"]["xyz"], np.eye(3)))
            for one in obstacles
        ]
        looked_at = [
            (a, b)
            for (a, ((one, k), _)), (b, ((other, m), _)) in combinations(enumerate(bodies), 2)
            if not (one == other and abs(k - m) <= 1)  # neighbours, or obstacles
            and not (one == other and {k, m} == {0, 2})  # which overlap in every posture
            and not (other == "object" and k == 6)  # hands
            and not (k == 0 and m == 0 and one != "object" and other != "object")  # what stands
        ]
        expected = min(mujoco_distances([geom for _, geom in bodies], looked_at))
        assert found.distances[sample] == pytest.approx(expected, abs=EXACT)


def test_between_the_samples_it_is_the_least_of_dense_samples():
    """Past the corner of a box, nearest between two of eleven samples."""
    corner = box("corner", [0.1, 0.1, 0.1], [0.0, 0.4, 0.45])
    cell = mrts.Cell.from_description(described([corner], shape={"box": [0.5, 0.3, 0.02]}))
    few, many = (mrts.clearance(cell, lifting(samples=count)) for count in (11, 1501))
    near = few.distance - many.distance
    assert abs(near) <= max(RESOLUTION, SHARE * many.distance)
    assert np.min(few.distances) >= few.distance
    assert np.min(many.distances) == pytest.approx(many.distance, abs=RESOLUTION)


def test_neighbours_are_left_out_and_other_links_are_not():
    """Two arms of one torso, whose shoulders are cylinders that overlap; then a forearm folded into the torso."""
    cell = mrts.load_cell(TORSO / "cell.yaml")
    found = mrts.clearance(cell, mrts.load_motion(TORSO / "lift.yaml"))
    assert 0 < found.distance < 0.2
    assert found.unseen == ()
    of_ur5 = mrts.load_cell(UR5 / "cell.yaml")
    motion = coordinate(of_ur5, lifting(samples=11))
    q = motion.q.copy()
    q[:, :6] = [0.0, -1.2, 3.1, 0.0, 0.0, 0.0]  # the left wrist back on the shoulder
    folded = replace(motion, q=q, dq=np.zeros_like(q), ddq=np.zeros_like(q))
    hit = CollisionModel(of_ur5).clearance(folded)
    assert hit.collides
    assert {name.split("/")[0] for name in hit.pair} == {"left"}


def test_surroundings_in_the_cell_file(tmp_path):
    trimesh.creation.box([0.1, 0.2, 0.3]).export(tmp_path / "crate.stl")
    crate = {"mesh": "crate.stl", "pose": {"xyz": [0, 1, 0]}}
    cell = mrts.Cell.from_description(described([crate, {"cylinder": {"radius": 0.1, "length": 1.0}}]), folder=tmp_path)
    assert [one.name for one in cell.surroundings] == ["obstacle", "obstacle2"]
    cell.to_yaml(tmp_path / "cell.yaml")
    again = mrts.load_cell(tmp_path / "cell.yaml")
    assert dumped(again.surroundings) == dumped(cell.surroundings)
    trimesh.creation.box([0.1, 0.2, 0.4]).export(tmp_path / "crate.stl")
    assert mrts.load_cell(tmp_path / "cell.yaml").surfaces != cell.surfaces
    twice = [box("table", [1, 1, 1], [0, 0, -2]), box("table", [1, 1, 1], [0, 0, 5])]
    for wrong, key in ((twice, "surroundings[1].name"), ([{"name": "nothing"}], "surroundings[0]")):
        with pytest.raises(mrts.InputError) as error:
            mrts.Cell.from_description(described(wrong))
        assert error.value.key == key


def test_a_layout_that_collides_is_no_answer(tmp_path):
    """A wall where the right arm would stand best: `mrts place` keeps clear of it, which it does not without."""
    ends = {"from": 0.65, "to": 0.85}
    vary = {"distance": {"sets": {"robots.left.base.xyz[0]": -1, "robots.right.base.xyz[0]": 1}} | ends}
    found = []
    for name, walls in (("free", []), ("walled", [box("wall", [0.02, 2, 2], [0.9, 0, 0])])):
        folder = tmp_path / name
        folder.mkdir()
        study = write_study(folder, described(walls), UR5 / "lift_and_turn.yaml", vary, count=4)
        found.append(mrts.place(study, starts=1, looked_at=4, between=None))
    free, walled = found
    assert ("collide" in free.reason, "collide" in walled.reason) == (False, True)
    assert walled.after is not None
    assert walled.after.c2 < free.after.c2
    for placed in found:
        cell = placed.after.result.cell
        assert not mrts.clearance(cell, placed.after.result.motion).collides


def test_meshes_of_links_and_object_are_as_their_shapes(tmp_path):
    """A box is as far away as its mesh in millimetres, as <collision>, and as <visual> where there is no other."""
    urdf = (UR5 / "ur5_class_arm.urdf").read_text(encoding="utf-8")
    tube, sides = '<cylinder radius="0.05" length="0.45"/>', [0.1, 0.1, 0.45]
    assert urdf.count(tube) == 1
    trimesh.creation.box([1000 * side for side in sides]).export(tmp_path / "forearm.stl")
    trimesh.creation.box([0.5, 0.3, 0.1]).export(tmp_path / "carried.stl")
    mesh = '<mesh filename="forearm.stl" scale="0.001 0.001 0.001"/>'
    as_visual = urdf.replace(tube, mesh).replace("collision>", "visual>")
    texts = [urdf.replace(tube, '<box size="0.1 0.1 0.45"/>'), urdf.replace(tube, mesh), as_visual]
    found = []
    wall = box("wall", [0.02, 3, 3], [-0.62, 0, 0.8])
    shapes = {"box": [0.5, 0.3, 0.1]}, {"mesh": "carried.stl"}, {"mesh": "carried.stl"}
    for text, shape in zip(texts, shapes, strict=True):
        (tmp_path / "arm.urdf").write_text(text, encoding="utf-8")
        given = described([wall], shape=shape)
        for robot in given["robots"]:
            robot["urdf"] = "arm.urdf"
        found.append(mrts.clearance(mrts.Cell.from_description(given, folder=tmp_path), lifting(samples=11)))
    assert found[0].pair == ("left/forearm", "wall")
    for other in found[1:]:
        assert other.pair == found[0].pair
        assert other.distances == pytest.approx(found[0].distances, abs=EXACT)


def test_without_coal_it_is_said_that_nothing_was_looked_at(monkeypatch):
    monkeypatch.setitem(sys.modules, "coal", None)
    found = check(UR5 / "cell.yaml", UR5 / "lift_and_turn.yaml")
    (said,) = [one for one in found.assumed if one.code == "no-collisions"]
    assert "mrts[collision]" in said.text
    assert found.clearance is None
    cell = mrts.load_cell(UR5 / "cell.yaml")
    with pytest.raises(mrts.InputError, check=lambda error: error.where == "collisions"):
        mrts.clearance(cell, lifting())


def test_studies_have_it_as_a_column(tmp_path):
    given = described([box("shelf", [0.6, 0.4, 0.002], [0, 0.2, 0.5])])
    text = 'vary: {"surroundings[0].pose.xyz[2]": [0.5, -0.5]}\nclearance: true'
    columns = solve_variants(planar_study(tmp_path, text, cell=given, motion=UR5 / "lift_and_turn.yaml"), 0, 2)
    assert columns["clearance"][0] < 0 < columns["clearance"][1]
    assert columns["c2_upper"][0] == columns["c2_upper"][1]

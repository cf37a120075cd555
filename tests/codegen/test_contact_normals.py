"""Normals of pads and cups against the object's shape: refused, or meant."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
import yaml
from mrts_codegen.cell_model import build_cell_model
from shipped_cells import shipped

import mrts
from mrts.base.rigid_transform import rotations_from_rpy, rpy_from_rotation
from mrts.cell.cell_file import CellDescription

PAD = {"friction": 0.5, "normal": [0, 0, 1], "half_width": [0.03, 0.02], "force": [0, 100]}
CUP = {"holding_force": 80, "friction": 0.5, "radius": 0.03, "normal": [0, 0, 1]}
SIDES, RADIUS, LENGTH, BALL = np.array([0.5, 0.3, 0.1]), 0.1, 0.4, 0.2
POSE = {"xyz": [0.02, -0.01, 0.03], "rpy": [0.3, -0.2, 0.5]}
SLANT = 0.7  # of a normal against its face, at most, as tan


def squeezed(object_=None, **robot):
    """What the shipped cell says, with another object and another left robot."""
    cell = shipped("squeeze")
    cell["object"] = {"mass": 6.0, "inertia": [0.05, 0.13, 0.17]} | (object_ or {})
    cell["robots"][0] |= robot
    return cell


def read(cell, folder="."):
    return build_cell_model(Path("cell.yaml"), CellDescription.read("cell.yaml", cell), Path(folder))


def place_on(shape, rng):
    """A point on a shape away from its edges, and the outward normal there."""
    if shape == "box":
        outward = np.eye(3)[rng.integers(3)] * rng.choice([-1, 1])
        inside = rng.uniform(-0.4, 0.4, 3)
        return np.where(outward != 0, outward / 2, inside) * SIDES, outward
    around = rng.normal(size=3)
    if shape == "sphere":
        return BALL * around / np.linalg.norm(around), around / np.linalg.norm(around)
    around = np.array([around[0], around[1], 0.0]) / np.hypot(around[0], around[1])
    if rng.integers(2):
        return RADIUS * around + np.array([0, 0, rng.uniform(-0.4, 0.4) * LENGTH]), around
    up = np.array([0, 0, rng.choice([-1.0, 1.0])])
    return 0.8 * RADIUS * rng.uniform() * around + up * LENGTH / 2, up


@pytest.mark.parametrize("kind", ["pad", "suction"])
@pytest.mark.parametrize("shape", ["box", "cylinder", "sphere"])
def test_a_normal_that_points_out_of_a_face_is_refused(shape, kind, tmp_path):
    trimesh.creation.icosphere(radius=1000 * BALL).export(tmp_path / "ball.stl")
    given = {
        "box": {"box": SIDES.tolist()},
        "cylinder": {"cylinder": {"radius": RADIUS, "length": LENGTH}},
        "sphere": {"mesh": "ball.stl", "scale": 0.001},
    }[shape] | {"pose": POSE}
    R_object_shape = rotations_from_rpy(np.array(POSE["rpy"]))
    rng = np.random.default_rng(4)
    for _ in range(6):
        point, outward = place_on(shape, rng)
        point = point + outward * rng.uniform(-0.005, 0.015)  # palms have a thickness, shapes are rough
        slant = np.cross(outward, rng.normal(size=3))
        into = -outward + SLANT * rng.uniform() * slant / np.linalg.norm(slant)
        tip = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        tip *= np.linalg.det(tip)
        xyz = R_object_shape @ point + POSE["xyz"]
        grasp = {"xyz": xyz.tolist(), "rpy": rpy_from_rotation(tip)}
        normal = tip.T @ R_object_shape @ into
        hand = PAD if kind == "pad" else CUP
        for sign, pull in ((1, False), (1, True), (-1, True)):
            described = hand | {"normal": (sign * normal).tolist(), "pull": pull}
            model = read(squeezed({"shape": given}, grasp=grasp, contact=[{kind: described}]), tmp_path)
            assert "contact-normal" not in {remark.code for remark in model.record.remarks}
        described = hand | {"normal": (-normal).tolist()}
        with pytest.raises(mrts.InputError) as refused:
            read(squeezed({"shape": given}, grasp=grasp, contact=[{kind: described}]), tmp_path)
        assert refused.value.key == f"robots[0] (left).contact[0].{kind}.normal"
        assert refused.value.value == described["normal"]


def test_both_palms_are_told_by_load_and_by_check_and_meant_ones_are_written_again(tmp_path):
    sheet = squeezed({"shape": {"box": [0.5, 0.3, 0.004]}}, grasp={"xyz": [0, 0, 0.0005], "rpy": [0, 0, 0]})
    for sign in (1, -1):  # in a sheet both ways are right
        sheet["robots"][0]["contact"] = [{"pad": PAD | {"normal": [0, 0, sign]}}]
        read(sheet)
    cell = squeezed({"shape": {"box": SIDES.tolist()}})
    for robot in cell["robots"]:
        robot["contact"][0]["pad"]["normal"] = [0, 0, -1]
    path = tmp_path / "cell.yaml"
    path.write_text(yaml.safe_dump(cell))
    keys = [f"robots[{index}] ({name}).contact[0].pad.normal" for index, name in enumerate(("left", "right"))]
    assert [mistake.key for mistake in mrts.check(path).mistakes] == keys
    with pytest.raises(mrts.InputError, check=lambda error: error.key == keys[0]):
        mrts.load_cell(path)
    for robot in cell["robots"]:
        robot["contact"][0]["pad"]["pull"] = True
    path.write_text(yaml.safe_dump(cell))
    again = yaml.safe_load(mrts.load_cell(path).to_yaml())
    assert [robot["contact"][0]["pad"]["pull"] for robot in again["robots"]] == [True, True]

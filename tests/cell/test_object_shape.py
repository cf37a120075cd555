"""The shape of the object: what it weighs where nothing is said of its inertia, and that it stays with the cell."""

import pickle

import numpy as np
import pytest
import trimesh
import yaml
from conftest import DATA
from scipy.spatial.transform import Rotation
from shipped_cells import cell_file, shipped

import mrts
from mrts.cell.generation import generate_to
from mrts.scene.held_body import held_body

ROUNDING = 1e-12
FLOAT32 = 1e-6  # vertices are drawn, and kept, in single precision
MASS = 1.5


def described(shape, **keys):
    return shipped() | {"object": {"mass": MASS, "shape": shape} | keys}


def shaped(folder, shape, **keys):
    """The planar cell with another object."""
    return mrts.Cell.from_description(described(shape, **keys), folder=folder)


def tetrahedron_inertia(mass, corners):
    """About its centre; Tonon, Explicit exact formulas for the 3-D tetrahedron inertia tensor, 2004, in matrix form."""
    about = corners - corners.mean(axis=0)
    second = mass / 20 * about.T @ about  # of mass times x xᵀ; the sum of the corners is 0
    return np.trace(second) * np.eye(3) - second


def test_a_uniform_body_has_the_inertia_of_its_shape(tmp_path):
    box = shaped(tmp_path, {"box": [0.3, 0.2, 0.1]})
    np.testing.assert_allclose(box.inertia, MASS / 12 * np.diag([0.05, 0.1, 0.13]), rtol=ROUNDING)
    can = shaped(tmp_path, {"cylinder": {"radius": 0.1, "length": 0.4}})
    across = MASS * (3 * 0.01 + 0.16) / 12
    np.testing.assert_allclose(can.inertia, np.diag([across, across, MASS * 0.01 / 2]), rtol=ROUNDING)
    corners = np.array([[0, 0, 0], [300, 20, 0], [50, 200, 10], [10, 40, 150.0]])
    centre = corners.mean(axis=0) / 1000
    for ending, faces in (
        ("stl", [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
        ("obj", [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]]),
    ):
        trimesh.Trimesh(corners, faces, process=False).export(tmp_path / f"part.{ending}")  # the second inside out
        R = Rotation.from_euler("xyz", [0.4, -0.3, 1.1])
        pose = {"xyz": (-R.apply(centre)).tolist(), "rpy": [0.4, -0.3, 1.1]}
        part = shaped(tmp_path, {"mesh": f"part.{ending}", "scale": 0.001, "pose": pose})
        turned = R.as_matrix() @ tetrahedron_inertia(MASS, corners / 1000) @ R.as_matrix().T
        np.testing.assert_allclose(part.inertia, turned, rtol=0, atol=FLOAT32 * turned.max())
    given = shaped(tmp_path, {"mesh": "part.obj"}, inertia=[1.0, 1.0, 1.0])
    np.testing.assert_array_equal(given.inertia, np.eye(3))
    assert "0.001" in given.remarks[0].text
    assert given.remarks[0].code == "large-shape"


MISTAKES = {
    "two kinds": ({"box": [1, 1, 1], "cylinder": {"radius": 1, "length": 1}}, "here are box and cylinder"),
    "flat": ({"box": [1, 0, 1]}, r"object\.shape\.box\[1\] = 0: must be > 0"),
    "aside": ({"box": [1, 1, 1], "pose": {"xyz": [0, 0.3, 0]}}, r"at \[0, 0\.3, 0\] .* 'pose: \{xyz: \[0, 0, 0\]\}'"),
    "no file": ({"mesh": "nothing.stl"}, "there is no such mesh"),
    "open": ({"mesh": "open.stl"}, r"open\.stl: this mesh is not closed"),
    "sheet": ({"mesh": "sheet.obj"}, "encloses no volume"),
    "other format": ({"mesh": "part.step"}, "is a file of stl, obj, ply, off"),
}


@pytest.fixture(scope="module")
def broken(tmp_path_factory):
    folder = tmp_path_factory.mktemp("meshes")
    box = trimesh.creation.box((0.3, 0.2, 0.1))
    trimesh.Trimesh(box.vertices, box.faces[:-1]).export(folder / "open.stl")
    (folder / "sheet.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n")
    (folder / "part.step").write_text("hello")
    return folder


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_in_a_shape(mistake, broken):
    shape, rule = MISTAKES[mistake]
    with pytest.raises(mrts.InputError, match=rule):
        shaped(broken, shape)


def test_it_stays_with_the_cell(tmp_path):
    """In a cell file written from it, a generated folder, another process, a saved result, and with more mass."""
    trimesh.creation.box((0.3, 0.2, 0.1)).export(tmp_path / "part.stl")
    pose = {"quaternion_wxyz": [0.7071, 0, 0, 0.7071]}
    path = cell_file(tmp_path, described({"mesh": "part.stl", "pose": pose}))
    cell = mrts.load_cell(path)
    drawn = held_body(cell)
    cell.to_yaml(tmp_path / "again.yaml")
    written = yaml.safe_load((tmp_path / "again.yaml").read_text(encoding="utf-8"))["object"]["shape"]
    assert written == {"mesh": "part.stl", "pose": {"xyz": [0, 0, 0]} | pose}
    generate_to(path, tmp_path / "generated")
    result = mrts.scale(cell, mrts.load_motion(DATA / "lift.yaml"), between=None)
    mrts.save_result(result, tmp_path / "result.npz")
    for other in (
        mrts.load_cell(tmp_path / "again.yaml"),
        mrts.load_cell(tmp_path / "generated"),
        pickle.loads(pickle.dumps(cell)),  # noqa: S301 (our own)
        mrts.load_result(tmp_path / "result.npz").cell,
        cell.with_mass(2.0),
    ):
        for ours, theirs in zip(drawn, held_body(other), strict=True):
            np.testing.assert_allclose(theirs, ours, rtol=0, atol=ROUNDING)
    trimesh.creation.box((0.3, 0.2, 0.2)).export(tmp_path / "part.stl")  # the cache has the old one
    assert mrts.load_cell(path).inertia[0, 0] == pytest.approx(MASS / 12 * (0.09 + 0.04))

"""Links and joints as we read them, against yourdfpy."""

import numpy as np
import pytest
from mrts_codegen.urdf.urdf_file import parse_urdf
from published_robots import CASES, urdf_path
from yourdfpy import URDF

SAME = 1e-15
"""Largest difference of a rotation that two products of sines round differently."""


@pytest.mark.parametrize("name", CASES)
def test_a_urdf_says_what_yourdfpy_reads(name):
    path = urdf_path(CASES[name][0])
    ours, theirs = (
        parse_urdf(path, path.read_bytes()),
        URDF.load(str(path), load_meshes=False, build_scene_graph=False).robot,
    )
    assert list(ours.links) == [link.name for link in theirs.links]
    for one, other in zip(ours.links.values(), theirs.links, strict=True):
        if other.inertial is None:
            assert (one.mass, np.any(one.inertia)) == (0, False)
        else:
            assert one.mass == other.inertial.mass
            np.testing.assert_array_equal(one.inertia, other.inertial.inertia)
            _assert_same_pose(one.origin, other.inertial.origin)
    for one, other in zip(ours.joints.values(), theirs.joints, strict=True):
        assert (one.name, one.type, one.parent, one.child) == (other.name, other.type, other.parent, other.child)
        np.testing.assert_allclose(one.axis * np.linalg.norm(other.axis), other.axis, atol=SAME)
        _assert_same_pose(one.origin, other.origin)
        given = {key: getattr(other.limit, key, None) for key in ("lower", "upper", "velocity", "effort")}
        given |= {"lower": None, "upper": None} if one.type == "continuous" else {}
        for key, none in (("lower", -np.inf), ("upper", np.inf), ("velocity", np.inf), ("effort", 0)):
            silent = given[key] is None or (key == "velocity" and given[key] == 0)
            assert getattr(one, key) == (none if silent else given[key])
        assert (one.mimic is None) == (other.mimic is None)
        if one.mimic is not None:
            mimic = other.mimic
            assert one.mimic == (mimic.joint, mimic.multiplier, mimic.offset)
        assert one.viscous == float(getattr(other.dynamics, "damping", None) or 0)
        assert one.coulomb == float(getattr(other.dynamics, "friction", None) or 0)


def _assert_same_pose(ours, theirs):
    matrix = np.eye(4) if theirs is None else theirs
    np.testing.assert_allclose(ours.R, matrix[:3, :3], atol=SAME)
    np.testing.assert_array_equal(ours.p, matrix[:3, 3])

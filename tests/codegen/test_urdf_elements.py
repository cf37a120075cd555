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
    assert [link.name for link in ours.links] == [link.name for link in theirs.links]
    for one, other in zip(ours.links, theirs.links, strict=True):
        assert (one.inertial is None) == (other.inertial is None)
        if one.inertial is not None:
            assert one.inertial.mass == other.inertial.mass
            np.testing.assert_array_equal(one.inertial.inertia, other.inertial.inertia)
            _assert_same_pose(one.inertial.origin, other.inertial.origin)
    for one, other in zip(ours.joints, theirs.joints, strict=True):
        assert (one.name, one.type, one.parent, one.child) == (other.name, other.type, other.parent, other.child)
        np.testing.assert_array_equal(one.axis, other.axis)
        _assert_same_pose(one.origin, other.origin)
        for key in ("lower", "upper", "velocity", "effort"):
            assert getattr(one, key) == getattr(other.limit, key, None)
        assert (one.mimic is None) == (other.mimic is None)
        if one.mimic is not None:
            mimic = other.mimic
            assert one.mimic == (mimic.joint, mimic.multiplier, mimic.offset)
        assert one.damping == float(getattr(other.dynamics, "damping", None) or 0)
        assert one.friction == float(getattr(other.dynamics, "friction", None) or 0)


def _assert_same_pose(ours, theirs):
    matrix = np.eye(4) if theirs is None else theirs
    np.testing.assert_allclose(ours.R, matrix[:3, :3], atol=SAME)
    np.testing.assert_array_equal(ours.p, matrix[:3, 3])

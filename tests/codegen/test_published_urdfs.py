"""URDFs as people publish them: read as yourdfpy does; let pass with a remark, or refused and why."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from mrts_codegen.cell_model import build_cell_model
from mrts_codegen.urdf.robot_model import build_robot_model, nearest_inertia
from mrts_codegen.urdf.urdf_file import parse_urdf
from published_robots import CASES, ROBOTS, urdf_path
from yourdfpy import URDF

import mrts
from mrts.cell.cell_file import CellDescription

REFUSALS = {
    r"no joint moves between": None,
    r"joint '\S+' mimic: it moves with": None,
    # inertias that no body has, by far more than rounding; the links that carry them are named
    r"link '\S+' inertia: breaks the triangle inequality": {
        "allegro_left_hand.urdf",
        "allegro_right_hand.urdf",
        "hyq_no_sensors.urdf",
        "pr2.urdf",
        "romeo_laas_small.urdf",
        "romeo_small.urdf",
    },
    r"link '\S+' inertia: is not positive definite": {"romeo_laas_small.urdf"},
}
"""Message to the files in which some chain may be refused so; None: any file."""

TALOS = ROBOTS / "talos_data/robots/talos_full_v2.urdf"
ROUNDING = 1e-13

LEAST_CHAINS = 430
"""Of the 721 from root to leaf in example-robot-data 6.0.0, 286 have nothing that moves, end in a follower, or break
the rules above."""


def test_every_published_chain_loads_or_is_refused_for_a_reason():
    loaded, seen = 0, set()
    for path in (path for path in sorted(ROBOTS.rglob("*.urdf")) if b"<link" in path.read_bytes()):
        urdf = parse_urdf(path, path.read_bytes())
        parents = {joint.parent for joint in urdf.joints.values()}
        for leaf in (link for link in urdf.links if link not in parents):
            try:
                model = build_robot_model(path, urdf, None, leaf)
            except mrts.InputError as error:
                refusal = str(error)
            else:
                assert all(joint.lower <= joint.upper and joint.velocity > 0 for joint in model.joints)
                loaded += 1
                continue
            reason = next(rule for rule in REFUSALS if re.search(rule, refusal))
            assert REFUSALS[reason] is None or path.name in REFUSALS[reason], refusal
            seen.add((reason, path.name))
    assert loaded >= LEAST_CHAINS
    assert {name for reason, name in seen if REFUSALS[reason]} == set().union(*filter(None, REFUSALS.values()))


@pytest.mark.parametrize(
    "moments", [(1, 1.5, 2), (1, 1, 2.5), (-1, 2, 5), (-3, 1, 5), (-1, -1, 3), (-1, -2, -3), (0, 0, 1), (1, 4.3, 7.3)]
)
def test_a_moved_inertia_is_the_nearest(moments):
    """X is the point nearest to A of the bodies' cone, tr(Σ) 1 - Σ with Σ >= 0, if and only if (Moreau) X is in it,
    D = A - X is normal to X, and no ray 1 - v vᵀ of the cone leads nearer: tr D <= vᵀ D v."""
    rotation = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    given = rotation @ np.diag(moments) @ rotation.T
    found = nearest_inertia(given)
    off = given - found
    assert np.min(np.linalg.eigvalsh(np.trace(found) / 2 * np.eye(3) - found)) >= -ROUNDING
    assert abs(np.sum(off * found)) <= ROUNDING
    assert np.trace(off) - np.min(np.linalg.eigvalsh(off)) <= ROUNDING


def with_inertia(urdf, name, inertia):
    """The same URDF with another inertia of a link."""
    return replace(urdf, links=urdf.links | {name: urdf.links[name]._replace(inertia=inertia)})


def test_a_humanoid_with_one_wrong_link():
    """Of the chain, or hanging from its torso; one that hangs from what stands still plays no part."""
    tip, talos = "gripper_left_base_link", parse_urdf(TALOS, TALOS.read_bytes())
    inertia = {name: link.inertia for name, link in talos.links.items()}
    leg = with_inertia(talos, "leg_left_4_link", inertia["leg_left_4_link"] * np.diag([1, 1, 6]))
    assert build_robot_model(TALOS, leg, None, tip).remarks == build_robot_model(TALOS, talos, None, tip).remarks
    for link in ("arm_left_3_link", "arm_right_5_link"):
        moments, axes = np.linalg.eigh(inertia[link])
        beyond = np.array([moments[0], moments[1], 2 * (moments[0] + moments[1])])
        wrong = with_inertia(talos, link, axes @ np.diag(beyond) @ axes.T)
        with pytest.raises(mrts.InputError, match="'inertia: lenient' in the cell file") as refusal:
            build_robot_model(TALOS, wrong, None, tip)
        assert refusal.value.key == f"link '{link}' inertia"
        model = build_robot_model(TALOS, wrong, None, tip, lenient=True)
        assert [remark.code for remark in model.remarks if link in remark.text] == ["inertia-nearest"]
        nearest = beyond + (moments[0] + moments[1]) / 3 * np.array([1, 1, -1])  # straight onto the facet
        same = build_robot_model(TALOS, with_inertia(talos, link, axes @ np.diag(nearest) @ axes.T), None, tip)
        for ours, theirs in zip(model.joints, same.joints, strict=True):
            np.testing.assert_allclose(ours.body.at_com, theirs.body.at_com, rtol=1e-12, atol=1e-15)


def arm_cell(folder, replacements):
    """The shipped planar cell with another arm."""
    text = (DATA / "planar_arm.urdf").read_text()
    for old, new in replacements:
        assert old in text, old
        text = text.replace(old, new)
    (folder / "planar_arm.urdf").write_text(text)
    return shutil.copy(DATA / "cell.yaml", folder / "cell.yaml")


def read(path):
    return build_cell_model(path, CellDescription.read_file(path, "cell file"))


@pytest.mark.parametrize("number", ["1.7976931348623157e308", "inf", "1000000000"])
def test_limits_that_mean_none(number, tmp_path):
    elbow = '<joint name="elbow" type='
    limit = f'<limit lower="-{number}" upper="{number}" velocity="{number}" effort="9"/>'
    path = arm_cell(tmp_path, [(f'{elbow}"continuous">', f'{elbow}"revolute">{limit}')])
    elbow = read(path).models[0].joints[1]
    assert (elbow.lower, elbow.upper, elbow.velocity, elbow.effort) == (-np.inf, np.inf, np.inf, 9)


HAND = '<inertia ixx="0.0025" ixy="0" ixz="0" iyy="0.0016666666666666668" iyz="0" izz="0.0016666666666666668"/>'


def hand(mass, xx, yy, zz):
    return [
        ('<mass value="0.5"/>', f'<mass value="{mass}"/>'),
        (HAND, f'<inertia ixx="{xx}" ixy="0" ixz="0" iyy="{yy}" iyz="0" izz="{zz}"/>'),
    ]


@pytest.mark.parametrize(
    ("mass", "moments", "code"),
    [
        (0.5, (0.001, 0.001, 0.002), None),  # a disc, at the edge
        (0.5, (0.001, 0.001, 0.00203), "inertia-triangle"),  # 1.5 % beyond, as link2 of pybullet's xArm 6 by 0.7 %
        (0.5, (0.001, 0.001, 0.002312), "inertia-triangle"),  # 15.6 %, as its link3
        (0.0, (0.1, 0.1, 0.1), "massless-inertia"),  # panda_link8 of pybullet's Panda
        (0.0, (0, 0, 0), None),  # a frame
        (0.5, (0, 0, 0), None),  # a point mass
        (0.5, (1e-20, -1e-20, 0), None),  # the same with rounding: iCub's ankles
        (0.5, (0, 0.0012, 0.0012), None),  # a rod without thickness: the finger's lower link
    ],
)
def test_what_is_let_pass(mass, moments, code, tmp_path):
    model = read(arm_cell(tmp_path, hand(mass, *moments)))
    assert [remark.code for remark in model.record.remarks] == ([code] if code else [])  # once, though two arms have it
    assert all("planar_arm.urdf: " in remark.text and "'hand'" in remark.text for remark in model.record.remarks)
    assert all(str(tmp_path) not in remark.text for remark in model.record.remarks)
    assert model.models[0].joints[2].body.mass == mass


SAME = 1e-15
"""Largest difference of a rotation that two products of sines round differently."""


@pytest.mark.parametrize("name", CASES)
def test_a_urdf_says_what_yourdfpy_reads(name):
    path = urdf_path(CASES[name][0])
    ours = parse_urdf(path, path.read_bytes())
    theirs = URDF.load(str(path), load_meshes=False, build_scene_graph=False).robot
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


def test_a_follower_off_the_chain_is_told():
    """Panda's other finger stays where it is while the chain's moves."""
    path = ROBOTS / "panda_description/urdf/panda.urdf"
    (remark,) = build_robot_model(path, parse_urdf(path, path.read_bytes()), None, "panda_leftfinger").remarks
    assert remark.code == "follower-at-zero"
    assert remark.text.startswith("panda.urdf: 'panda_finger_joint2' would move with joint 'panda_finger_joint1'")
    assert not build_robot_model(path, parse_urdf(path, path.read_bytes()), None, "panda_hand").remarks

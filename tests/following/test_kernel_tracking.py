"""The kernel's tracker: what it follows holds the grasps, what it does not cannot be held from there."""

from collections import Counter

import numpy as np
import pytest
from changed_robots import with_robots
from conftest import DATA
from scipy.optimize import least_squares

import mrts
from mrts.base.rigid_transform import rotations_from_vectors
from mrts.following.coordinate import tip_rates
from mrts.following.coordinated_motion import carried_by_each
from mrts.following.tracking import CONDITION_LIMIT, FURTHER_STEPS, follow_from, reached, solve_grasps
from mrts.kernel.tracking import FOLLOWED, LOST, OUT_OF_REACH, SINGULAR
from mrts.motion.object_courses import PROFILES

CELLS = ("planar_dual_arm", "dual_ur5", "redundant")

HELD = 1e-9
"""[m, rad, and their rates]: poses are solved to 1e-10."""


def free_cell(name):
    """A cell whose joints turn without limits."""
    cell = mrts.load_cell(DATA.parent / name / "cell.yaml")
    free = np.inf * np.ones(len(cell.robots[0].joints))
    return with_robots(cell, position_lower=-free, position_upper=free)


def drawn_motion(rng, cell, samples=21):
    """From where the first arm holds the object at its posture, some way or far, straight and turning."""
    (robot, *_), q = cell.robots, np.concatenate([each.posture for each in cell.robots])[None]
    poses = cell.functions("kinematics", 1, {"q": q})
    R = poses["rotation"][0][:, :3] @ robot.T_object_tip.R.T
    p = poses["position"].reshape(3, -1)[:, 0] - R @ robot.T_object_tip.p
    way, turn = rng.choice([0.1, 0.6]) * rng.normal(size=(2, 3))
    if cell.plane is not None:
        (normal,) = {*"xyz"} - {*cell.plane}
        way["xyz".index(normal)] = 0
        turn[["xyz".index(axis) for axis in cell.plane]] = 0
    time = np.linspace(0, 1, samples)
    s, ds, dds = (part[:, None] for part in PROFILES["quintic"](time))
    rates, changes = (np.concatenate([part * way, part * turn], axis=1) for part in (ds, dds))
    return mrts.ObjectMotion(time, p + s * way, rotations_from_vectors(s * turn) @ R, rates, changes)


def gap_left(cell, motion, sample, joints, index, start):
    """The least that scipy leaves of an arm's grasp at a sample, from joints that are near [m, rad]."""
    grasp = cell.robots[index].T_object_tip.p

    def off(q):
        whole = start[None].copy()
        whole[:, joints] = q
        own = carried_by_each(cell, np.zeros(1), whole, 0 * whole, 0 * whole)[index]
        turned = own.rotation[0] - motion.rotation[sample]
        return np.concatenate([own.position[0] - motion.position[sample] + turned @ grasp, turned.ravel()])

    return np.max(np.abs(least_squares(off, start[joints], xtol=1e-15, ftol=1e-15, gtol=1e-15).fun))


@pytest.mark.parametrize("name", CELLS)
def test_what_is_followed_holds_its_grasp_and_what_is_not_cannot_be_held(name):
    rng, cell = np.random.default_rng(5), free_cell(name)
    met = Counter()
    for _ in range(30):
        motion, reference = drawn_motion(rng, cell), cell.posture
        posture = reference + rng.choice([0.0, 0.02, 0.2]) * rng.normal(size=len(reference))
        start, gap, turn, _ = solve_grasps(cell, motion, slice(1), posture[None], FURTHER_STEPS, near=posture)
        found = follow_from(cell, motion, start)
        q, dq, ddq = found.q[0], found.dq[0], found.ddq[0]
        carried = carried_by_each(cell, motion.time, q, dq, ddq)
        for index, (robot, joints) in enumerate(zip(cell.robots, cell.joint_slices.values(), strict=True)):
            if not reached(gap, turn)[0, index]:
                continue
            code, sample = found.outcome[0, index]["code"], found.outcome[0, index]["sample"]
            met[code] += 1
            held = slice(None if code == FOLLOWED else sample)
            for of in ("position", "rotation"):
                apart = getattr(carried[index], of)[held] - getattr(motion, of)[held]
                assert np.max(np.abs(apart), initial=0) < HELD
            pairs = zip(tip_rates(cell, robot, carried[index]), tip_rates(cell, robot, motion), strict=True)
            for ours, rate in pairs:
                np.testing.assert_allclose(ours[held], rate[held], rtol=HELD, atol=HELD * (1 + np.max(np.abs(rate))))
            assert np.max(np.abs(np.diff(q[held, joints], axis=0)), initial=0) < 3 * 0.5  # MRTS_JUMP
            if code in {FOLLOWED, OUT_OF_REACH}:
                last = sample if code == OUT_OF_REACH else len(motion.time) - 1
                gap = gap_left(cell, motion, last, joints, index, q[last - (code == OUT_OF_REACH)])
                assert (gap > HELD) == (code == OUT_OF_REACH)
    assert {*met} >= {FOLLOWED, OUT_OF_REACH, LOST}


@pytest.mark.parametrize("name", CELLS)
def test_an_arm_that_is_stretched_out_is_singular(name):
    cell = free_cell(name)
    joint = {"planar_dual_arm": 1, "dual_ur5": 2, "redundant": 3}[name]
    start = cell.posture * (np.arange(len(cell.posture)) != joint)
    cell = cell.with_postures({cell.robots[0].name: start[: len(cell.robots[0].joints)].tolist()})
    J = cell.functions("kinematics", 1, {"q": start[None]})["jacobian"][0][:, : len(cell.robots[0].joints)]
    assert np.linalg.cond(J) > CONDITION_LIMIT
    found = follow_from(cell, drawn_motion(np.random.default_rng(7), cell), start[None])
    assert (found.outcome[0, 0]["code"], found.outcome[0, 0]["sample"]) == (SINGULAR, 0)

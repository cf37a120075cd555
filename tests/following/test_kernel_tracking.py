"""The kernel's tracker against the one in numpy: outcomes and the samples at which they are met, q, q' and q''."""

from collections import Counter

import numpy as np
import pytest
from changed_robots import with_robots
from conftest import DATA
from grasp_tracking import held, tracked

import mrts
from mrts.base.rigid_transform import rotations_from_vectors
from mrts.following.tracking import (
    FURTHER_STEPS,
    SETTLED_PREFERENCE,
    follow_from,
    reached,
    solve_grasps,
    starting_reference,
)
from mrts.kernel.tracking import FOLLOWED, LOST, OUT_OF_REACH, SINGULAR
from mrts.motion.velocity_profile import PROFILES

KINDS = {"planar_dual_arm": {LOST}, "dual_ur5": {LOST}, "redundant": {LOST}}
"""Cells, and what their arms come to besides following and what is out of reach."""

SAME = 1e-9
"""Of joint positions, and of their rates beside the largest: both are solved to 1e-10 in the tip's pose."""


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


@pytest.mark.parametrize("name", KINDS)
def test_arms_follow_and_fail_as_in_numpy(name):
    rng, cell = np.random.default_rng(5), free_cell(name)
    met = Counter()
    for _ in range(60):
        motion = drawn_motion(rng, cell)
        posture = starting_reference(cell) + rng.choice([0.0, 0.02, 0.2]) * rng.normal(
            size=len(starting_reference(cell))
        )
        starts = solve_grasps(cell, motion, 0, posture[None], FURTHER_STEPS, near=posture)
        found = follow_from(cell, motion, starts.q)
        for index, joints in enumerate(cell.joint_slices.values()):
            if not reached(starts)[0, index] or starts.drift[0, index] > SETTLED_PREFERENCE:
                continue
            outcome = found.outcome[0, index]
            parts, code, sample = tracked(cell, index, motion, starts.q[0])
            met[code] += 1
            assert (outcome["code"], outcome["sample"]) == (code, 0 if code == FOLLOWED else sample)
            for ours, theirs in zip((found.q, found.dq, found.ddq), parts, strict=True):
                near = SAME * (1 + np.max(np.abs(theirs[:sample])))
                np.testing.assert_allclose(ours[0, :sample, joints], theirs[:sample], rtol=0, atol=near)
    assert {*met} >= {FOLLOWED, OUT_OF_REACH} | KINDS[name]


@pytest.mark.parametrize("name", KINDS)
def test_an_arm_that_is_stretched_out_is_singular(name):
    cell = free_cell(name)
    joint = {"planar_dual_arm": 1, "dual_ur5": 2, "redundant": 3}[name]
    start = starting_reference(cell) * (np.arange(len(starting_reference(cell))) != joint)
    cell = cell.with_postures({cell.robots[0].name: start[: len(cell.robots[0].joints)].tolist()})
    found = follow_from(cell, drawn_motion(np.random.default_rng(7), cell), start[None])
    code = tracked(cell, 0, drawn_motion(np.random.default_rng(7), cell), start)[1]
    assert (found.outcome[0, 0]["code"], code) == (SINGULAR, SINGULAR)


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("near", [True, False])
def test_grasps_are_held_as_in_numpy(name, near):
    rng, cell = np.random.default_rng(6), free_cell(name)
    motion = drawn_motion(rng, cell)
    samples = rng.integers(len(motion.time), size=12)
    starts = starting_reference(cell) + 0.1 * rng.normal(size=(12, len(starting_reference(cell))))
    reference = starting_reference(cell) if near else None
    found = solve_grasps(cell, motion, samples, starts, FURTHER_STEPS, near=reference)
    for index, joints in enumerate(cell.joint_slices.values()):
        for number, sample in enumerate(samples):
            q, gap, turn, drift = held(cell, index, motion, sample, starts[number], reference, FURTHER_STEPS)
            np.testing.assert_allclose(found.q[number, joints], q[joints], rtol=0, atol=SAME)
            sizes = [each[number, index] for each in (found.gap, found.turn, found.drift)]
            np.testing.assert_allclose(sizes, [gap, turn, drift], rtol=1e-6, atol=SAME)

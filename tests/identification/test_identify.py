"""Motors from recordings: known ones are found again, with the confidence that is claimed, or it is said why not."""

import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import yaml
from conftest import DATA, UR5
from motor_recordings import (
    EFFORT_NOISE,
    Motors,
    exact_efforts,
    exact_recording,
    measured,
    names,
    random_motors,
    recording,
    simulated,
)
from scipy.integrate import cumulative_simpson
from scipy.signal import lfilter

import mrts
from mrts.identification.identify import fit_joint

SAME = 1e-9
"""Relative to the largest number of a fit: rounding of normal equations of four well scaled unknowns."""


def best_of_all_bounds(columns, left_over):
    """The least sum of squares of all sets of parameters that are held at 0."""
    X = np.column_stack([columns, np.ones(len(columns))])
    best = (np.inf, np.zeros(4))
    for free in product([False, True], repeat=3):
        chosen = np.flatnonzero([*free, True])
        theta = np.zeros(4)
        theta[chosen] = np.linalg.lstsq(X[:, chosen], left_over)[0]
        if np.all(theta[:3] >= 0):
            best = min(best, (float(np.sum((left_over - X @ theta) ** 2)), theta), key=lambda pair: pair[0])
    return best[1]


@pytest.mark.quick
def test_bounded_least_squares_are_the_best_of_all_choices():
    rng = np.random.default_rng(30)
    held = 0
    for _ in range(200):
        dq = rng.uniform(0.2, 2, 40) * rng.choice([-1, 1], 40)
        columns = np.column_stack([rng.uniform(-6, 6, 40), np.sign(dq), dq])
        left_over = columns @ rng.uniform(-0.5, 1, 3) * 3 + rng.normal(0, 0.1, 40) + 1
        used = np.ones(len(columns), bool)
        found, half, reasons, bounded = fit_joint(columns, left_over, used, fastest=3.0, torque_limit=1e9)
        expected = best_of_all_bounds(columns, left_over)
        np.testing.assert_allclose(found, expected, atol=SAME * np.max(np.abs(expected)))
        np.testing.assert_array_equal(bounded, expected[:3] == 0)
        assert {*reasons} == {""}
        X = np.column_stack([columns, np.ones(40)])[:, np.append(~bounded, True)]
        left = left_over - X @ found[np.append(~bounded, True)]
        ordinary = np.sqrt(np.diag(np.linalg.inv(X.T @ X)) * (left @ left) / (40 - X.shape[1]))
        assert np.all(half[~bounded] > 2 * ordinary[:-1])  # the bounds' part of what is left is in doubt too
        held += int(np.count_nonzero(bounded))
    assert held > 100


FILE = Path("recorded.csv")
KINDS = ("armature", "viscous", "coulomb")
EXACT = 1e-6
"""Relative: what a filter of 100 Hz takes of the torques of links that move at 1 Hz, and rounding of differences."""
FOUND = 0.02
"""Relative, of any parameter in any of the noisy recordings: the issue's bound."""
SEEDS = 25
BY_CHANCE = 4.0
"""Standard deviations that the share of intervals that hold the truth may be off 95 %; recordings are independent."""

SIMULATED = {
    "planar": (
        DATA / "planar_arm.urdf",
        Motors(np.array([0.5, 0.4, 0.3]), np.array([6.0, 4.0, 3.0]), np.array([8.0, 5.0, 2.5])),
    ),
    "ur5": (
        UR5 / "ur5_class_arm.urdf",
        Motors(
            np.array([0.66, 0.66, 0.66, 0.18, 0.18, 0.18]),
            np.array([16.5, 16.5, 12.0, 4.0, 4.0, 4.0]),
            np.array([19.8, 19.8, 12.0, 3.5, 3.5, 3.5]),
        ),
    ),
}


@pytest.fixture(scope="module", params=SIMULATED)
def simulation(request, planar_cell, dual_ur5):
    """A cell, its left arm, its motors, and what MuJoCo makes of them."""
    cell = planar_cell if request.param == "planar" else dual_ur5
    urdf, motors = SIMULATED[request.param]
    return cell, cell.robots[0], motors, simulated(cell, cell.robots[0], urdf, motors)


def claimed(cell, robot, motors, runs):
    """Relative errors of the parameters of all runs, and whether the interval holds the truth, Shape (runs, 3, n)."""
    errors, held = [], []
    for time, q, effort in runs:
        arm = mrts.identify(cell, recording(FILE, names(robot), time, q, effort)).arms[0]
        off = np.array([arm.value[kind] - getattr(motors, kind) for kind in KINDS])
        errors.append(off / [getattr(motors, kind) for kind in KINDS])
        held.append(np.abs(off) <= [arm.half_width[kind] for kind in KINDS])
    return np.array(errors), np.array(held)


def test_motors_of_a_simulator_are_found_within_their_intervals(simulation):
    cell, robot, motors, (time, q, effort) = simulation
    runs = [(time, *measured(robot, q, effort, np.random.default_rng(seed))) for seed in range(SEEDS)]
    errors, held = claimed(cell, robot, motors, runs)
    print("largest relative errors", np.abs(errors).max(axis=0))
    assert np.abs(errors).max() < FOUND
    allowed = BY_CHANCE * np.sqrt(0.95 * 0.05 / held.size)
    print(f"intervals that hold the truth: {held.mean():.4f} of {held.size}, allowed off 0.95 by {allowed:.4f}")
    assert abs(held.mean() - 0.95) < allowed


def test_intervals_hold_where_noise_has_a_memory(simulation):
    """Of 50 ms, two and a half times a block: residuals depend on each other."""
    cell, robot, motors, (time, q, effort) = simulation
    memory = np.exp(-1e-3 / 0.05)
    size = EFFORT_NOISE * robot.torque_upper * np.sqrt(1 - memory**2)
    runs = []
    for seed in range(SEEDS):
        steps = np.random.default_rng(100 + seed).standard_normal(effort.shape)
        runs.append((time, q, effort + size * lfilter([1], [1, -memory], steps, axis=0)))
    _, held = claimed(cell, robot, motors, runs)
    print("intervals that hold the truth", held.mean())
    assert held.mean() > 0.9  # estimated from the residuals' own memory, of which three blocks are seen


@pytest.mark.quick
@pytest.mark.parametrize("name", ["planar_cell", "dual_ur5"])
def test_exact_recordings_give_exact_motors(name, request):
    cell = request.getfixturevalue(name)
    motors = random_motors(sum(len(robot.joints) for robot in cell.robots))
    found = mrts.identify(cell, recording(FILE, *exact_recording(cell, motors)), cutoff=100)
    assert found.remarks == ()
    assert not found.empty
    for kind in KINDS:
        values = np.concatenate([arm.value[kind] for arm in found.arms])
        assert np.max(np.abs(values / getattr(motors, kind) - 1)) < EXACT
    assert max(np.max(np.abs(arm.offset)) for arm in found.arms) < EXACT
    assert repr(found) == f"<MotorIdentification of {cell.name}: left, right>"


@pytest.mark.quick
def test_a_recording_says_the_same_at_uneven_times_of_each_joint(planar_cell):
    """Stamps with jitter, joints of other rates and starts, an hour after the epoch, and a gap of a second."""
    motors = random_motors(6)
    joints, time, q, effort = exact_recording(planar_cell, motors, rate=2000)
    rng = np.random.default_rng(8)
    parts = {}
    for place, name in enumerate(joints):
        keep = np.sort(rng.choice(len(time), 2 * len(time) // 3, replace=False))
        keep = keep[(time[keep] > 0.1 * place) & ~((time[keep] > 7) & (time[keep] < 8))]
        parts[name] = mrts.RecordedJoint(3600 + time[keep], q[keep, place], effort[keep, place])
    found = mrts.identify(planar_cell, mrts.JointRecording(FILE, parts, {}))
    for kind in KINDS:
        values = np.concatenate([arm.value[kind] for arm in found.arms])
        np.testing.assert_allclose(values, getattr(motors, kind), rtol=2e-3)  # friction jumps between uneven samples
    motion = found.arms[0].motion
    unsampled = (motion.time > 6.8) & (motion.time < 7.8)
    assert np.any(unsampled)
    assert not np.any(motion.used[unsampled])


def test_a_joint_that_does_not_move_is_left_out(planar_cell):
    motors = random_motors(6)
    found = mrts.identify(planar_cell, recording(FILE, *exact_recording(planar_cell, motors, still=(1,))))
    left, right = found.arms
    for kind in KINDS:
        np.testing.assert_array_equal(left.reasons[kind] == "", [True, False, True])
        assert (left.value[kind][1], left.half_width[kind][1]) == (0, np.inf)
        np.testing.assert_allclose(right.value[kind], getattr(motors, kind)[3:], rtol=1e-4)
    assert {remark.code for remark in found.remarks} == {"not-excited"}
    assert len(found.remarks) == 3
    assert "coulomb of 'left/elbow' is not identified: it hardly moves" in str(found.remarks[1])
    text = found.to_yaml()
    blocks = {robot["name"]: robot.get("motors") for robot in yaml.safe_load(text)["robots"]}
    assert blocks["left"] is None
    assert set(blocks["right"]) == {"armature", "friction"}
    assert "#   elbow: it hardly moves in the recording" in text
    assert "15 of 18 parameters" in found.sentence()
    assert not found.empty


def to_and_fro(time):
    """At one speed, but for 50 ms around each turn: positions, velocities, accelerations."""
    phase, sharp = np.pi * (time + 0.7) / 2, 0.02
    square = np.tanh(np.sin(phase) / sharp)
    ddx = 0.5 * (1 - square**2) * np.cos(phase) / sharp * np.pi / 2
    return cumulative_simpson(0.5 * square, x=time, initial=0), 0.5 * square, ddx


def one_way(time):
    return 0.5 * time - 0.2 * np.cos(2 * time), 0.5 + 0.4 * np.sin(2 * time), 0.8 * np.cos(2 * time)


@pytest.mark.parametrize(
    ("motion", "told"),
    [
        (to_and_fro, {"armature": "in doubt", "viscous": "one speed", "coulomb": "one speed"}),
        (one_way, {"coulomb": "one way only"}),
    ],
)
def test_what_a_motion_cannot_tell_apart_is_left_out(planar_cell, motion, told):
    """Of the left wrist; nothing else moves."""
    motors = random_motors(6)
    joints, time, q, _ = exact_recording(planar_cell, motors, still=range(6))
    dq, ddq = np.zeros_like(q), np.zeros_like(q)
    turned, dq[:, 2], ddq[:, 2] = motion(time)
    q[:, 2] += turned
    effort = exact_efforts(planar_cell, motors, q, dq, ddq)
    wrist = planar_cell.robots[0]
    noisy = measured(wrist, q[:, :3], effort[:, :3], np.random.default_rng(4))
    arm = mrts.identify(planar_cell, recording(FILE, joints[:3], time, *noisy)).arms[0]
    for kind in KINDS:
        assert told.get(kind, "") in arm.reasons[kind][2]
        assert (arm.reasons[kind][2] == "") == (kind not in told)


def test_noise_of_positions_is_said_to_take_inertia(planar_cell):
    """And it takes as much as is said."""
    motors = random_motors(6)
    joints, time, q, effort = exact_recording(planar_cell, motors)
    rng = np.random.default_rng(3)
    quiet, noisy = (
        mrts.identify(planar_cell, recording(FILE, joints, time, q + size * rng.standard_normal(q.shape), effort))
        for size in (1e-4, 3e-3)
    )
    assert quiet.remarks == ()
    said = [remark.text for remark in noisy.remarks if remark.code == "noisy-positions"]
    assert len(said) == 6
    shares = np.array([float(re.search(r"is ([\d.]+) %", text).group(1)) / 100 for text in said])
    lost = 1 - np.concatenate([arm.value["armature"] for arm in noisy.arms]) / motors.armature
    wrists = [2, 5]  # which turn next to nothing but their armature
    np.testing.assert_allclose(lost[wrists], shares[wrists], rtol=0.5)


def test_currents_are_no_torques(dual_ur5):
    """Efforts in A, as some drivers publish them: ten times smaller than the torques that gravity asks for."""
    joints, time, q, effort = exact_recording(dual_ur5, random_motors(12))
    found = mrts.identify(dual_ur5, recording(FILE, joints, time, q, effort / 10))
    assert "left/shoulder_lift" in "".join(r.text for r in found.remarks if r.code == "unexplained-effort")


def test_units_of_positions_are_doubted(dual_ur5):
    joints, time, q, effort = exact_recording(dual_ur5, random_motors(12))
    with pytest.raises(mrts.InputError, match=r"recorded\.csv: position of left/\w+ = \d.*are these degrees\?"):
        mrts.identify(dual_ur5, recording(FILE, joints, time, np.rad2deg(q), effort))

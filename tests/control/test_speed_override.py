"""A plan at a speed that changes: Pinocchio's torques, every limit at every tick, stops within what is promised.

Wishes are random, the worst that a search finds, or no wishes at all.
"""

import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from changed_robots import with_robots
from command_line import mrts_command
from conftest import ROOT
from gantries import gantries, loop, there_and_back
from random_cells import configuration
from random_motors import equipped
from reference import ReferenceCell
from shipped_cells import DATA

import mrts
from mrts.cell.points import CarriedThing
from mrts.following.coordinated_motion import carried_by_first
from mrts.limits import limit_rows
from mrts.motion.object_courses import quintic
from mrts.program.infeasibility import motion_widening
from mrts.program.motion_rows import motion_rows

STUBS = ROOT / "tests" / "helpers" / "ros2_stubs"

SAME = 1e-9
"""Share of a torque by which the exported one differs: rounding, and another compiler's order of sums."""


@pytest.mark.slow
def test_it_plays_the_plan_from_its_start_to_its_end(turned, tmp_path):
    mrts.save_result(turned, tmp_path / "plan.npz")
    cell, library = DATA / "dual_ur5" / "cell.yaml", tmp_path / "library"
    done = mrts_command("export", cell, "--plan", tmp_path / "plan.npz", "-o", library)
    assert done.returncode == 0, done.stderr
    subprocess.run([shutil.which("make"), "-s", "-C", library], check=True, capture_output=True)
    checks = ["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    folders = [f"-I{folder}" for folder in (library / "include", STUBS, ROOT / "docs")]
    built = [STUBS / "play.cpp", *library.glob("build/*.a"), "-lm", "-o", tmp_path / "play"]
    subprocess.run([shutil.which("g++"), *checks, *folders, *built], check=True)
    said = subprocess.run([tmp_path / "play"], check=True, capture_output=True, text=True).stdout
    rest = mrts.SpeedOverride(turned).start(turned.duration).torque[:2]
    np.testing.assert_allclose(np.array(said.split(), dtype=float), rest, rtol=SAME)


ROUNDING = 1e-9
"""Largest difference to Pinocchio's torques, as a share of a torque limit."""

BETWEEN = 2e-4
"""Share of a limit by which a tick may pass it: twice what tables are made to, for places where nobody looked."""

FOLLOWED = 1e-3
"""The same of a plan that was followed between its samples to 1e-4."""

AXES = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

MOTORS = {"armature": [0.5, 0.4, 0.1], "coulomb": [6, 5, 2], "viscous": [8, 8, 3]}
MOTORS |= {"torque_speed": [[0, 100], [1.5, 100], [4, 30]]}

CELLS = (
    "planar_dual_arm",
    "planar_dual_arm with motors",
    "dual_ur5",
    "three_arms",
    "squeeze",
    "redundant",
    "uncertain_load",
)
PROFILES = ("constant", "fastest", "smooth")
TICKS = 48_000
"""Of each cell and profile: a million of all."""

PLAYED = [
    ("planar_dual_arm", "fastest"),
    ("dual_ur5", "constant"),
    ("dual_ur5", "smooth"),
    ("squeeze", "constant"),
    ("planar_dual_arm with motors", "fastest"),
]


def shipped_motion_of(name):
    """A shipped cell, with motors where its name ends so, and its motion."""
    folder = DATA / name.split(" ")[0]
    motion = next(path for path in (folder / "lift.yaml", folder / "lift_and_turn.yaml") if path.exists())
    cell = mrts.load_cell(folder / "cell.yaml")
    return equipped(cell, **MOTORS) if name.endswith("motors") else cell, mrts.load_motion(motion)


def played_plan(name, profile):
    """The override of a cell's plan."""
    cell, motion = shipped_motion_of(name)
    if profile == "constant":
        return mrts.SpeedOverride(mrts.scale(cell, motion))
    return mrts.SpeedOverride(mrts.retime(cell, motion, **({"rates": 10} if profile == "smooth" else {})))


def passed(cell, states):
    """By what share each state passes a limit: torques, wrenches and motors by hand, others as the cell has them."""
    found = [np.full(len(states), -1.0)]
    for part in ("torque", "wrench"):
        low, high = (
            np.concatenate([getattr(of, f"{part}_{side}") for of in cell.robots]) for side in ("lower", "upper")
        )
        for value, least, most in zip(states[part].T, low, high, strict=True):
            if np.isfinite([least, most]).all():
                found.append(np.maximum(value - most, least - value) / max(-least, most))
    curves = [curve for robot in cell.robots for curve in robot.motors.torque_speed]
    for torque, dq, curve in zip(states["torque"].T, states["dq"].T, curves, strict=True):
        if curve is not None:
            speed, most = curve.T
            beyond = (np.abs(torque) - np.interp(np.abs(dq), speed, most)) / most[0]
            found += [np.where(torque * dq > 0, beyond, -1.0), np.abs(dq) / speed[-1] - 1]
    return np.max([*found, np.max(others(cell, states), axis=1)], axis=0)


def carried(cell, states):
    """The motion at the states, as the first arm carries the object."""
    parts = (np.array(states[name]) for name in ("q", "dq", "ddq"))
    return carried_by_first(cell, np.arange(len(states), dtype=float), *parts)


def others(cell, states):
    """By what share they pass each row of the cell."""
    rows = limit_rows(cell, carried(cell, states))
    return rows.excess(rows.value(np.array(states["torque"]), np.array(states["wrench"]), 0.0, 1.0))


def drawn_ticks(override, rng, count):
    """States after ticks of all lengths (steps, ramps, stops, wishes beyond what is allowed), and where runs begin."""
    state, begins, held, wanted, slope = override.start(), [0], 0, 1.0, 0.0
    states = np.zeros(count, state.numbers.dtype)
    for k in range(count):
        if not held:
            held, kind = int(rng.integers(1, 80)), rng.integers(5)
            wanted = [0.0, 1.0, rng.uniform(0, 1.5), wanted, rng.uniform(-0.5, 1.2)][kind]
            slope = rng.normal(0, 0.05) if kind == 3 else 0.0
        held, wanted = held - 1, wanted + slope
        state = override.step(state, wanted, 1e-3 * rng.uniform(0.2, 2))
        states[k] = state.numbers
        if state.finished or rng.random() < 1e-3:
            joined = override.start(rng.uniform(0, override.duration), rng.uniform(0, 1))
            state = joined if state.finished or rng.random() < 0.5 else override.resume(state.q, 0.1)
            begins.append(k + 1)
    return states, np.array(begins)


@pytest.fixture(scope="module", params=PLAYED, ids=" ".join)
def played(request):
    """A plan, a thousand wishes that it was played by, and the file of its cell."""
    override = played_plan(*request.param)
    name = request.param[0].split(" ")[0]
    return override, override.play(wishes(np.random.default_rng(1), 1000)), DATA / name / "cell.yaml"


@pytest.fixture(scope="module")
def slow_lift():
    """A plan far below what limits allow."""
    return mrts.scale(*shipped_motion_of("planar_dual_arm"), 0.3)


def wishes(rng, ticks):
    """Steps, ramps and stops."""
    held = np.repeat(rng.choice([0.0, 1.0, 0.3, 1.5, -0.2], ticks), rng.integers(1, 40, ticks))[:ticks]
    ramp = np.cumsum(rng.normal(0, 0.05, ticks)) % 1.2
    return np.where(np.arange(ticks) % 400 < 250, held, ramp)


def test_torques_carry_the_object_as_pinocchio_has_it(played):
    override, states, path = played
    reference, cell = ReferenceCell(path), override.cell
    for state in states[::50]:
        needed = np.zeros(6)
        for arm, robot in zip(reference.arms, cell.robots, strict=True):
            joints, wrenches = cell.joint_slices[robot.name], cell.wrench_slices[robot.name]
            q, dq, ddq, torque = (state[name][joints] for name in ("q", "dq", "ddq", "torque"))
            full, wrench = configuration(arm.model, q), np.zeros(6)
            wrench[reference.rows] = state["wrench"][wrenches]
            free = pin.rnea(arm.model, arm.data, full, dq, ddq)
            J = pin.computeFrameJacobian(arm.model, arm.data, full, arm.frame, AXES)
            motors, moves = robot.motors, dq != 0
            own = free + J.T @ wrench + motors.armature * ddq + motors.viscous * dq + motors.coulomb * np.sign(dq)
            own, torque = (np.where(moves | (motors.coulomb == 0), of, 0.0) for of in (own, torque))
            assert np.max(np.abs(own - torque) / robot.torque_upper) <= ROUNDING
            pin.forwardKinematics(arm.model, arm.data, full, dq, ddq)
            pose = arm.base * pin.updateFramePlacement(arm.model, arm.data, arm.frame) * arm.grasp.inverse()
            r = pose.rotation @ arm.grasp.translation
            force, moment = (arm.base.rotation @ part for part in wrench.reshape(2, 3))
            needed += np.concatenate([force, moment + np.cross(r, force)])
        # what the object takes, as the first arm moves it
        first = reference.arms[0]
        q, dq, ddq = (state[name][: first.model.nv] for name in ("q", "dq", "ddq"))
        pin.forwardKinematics(first.model, first.data, configuration(first.model, q), dq, ddq)
        pose = first.base * pin.updateFramePlacement(first.model, first.data, first.frame) * first.grasp.inverse()
        R, r = first.base.rotation, pose.rotation @ first.grasp.translation
        twist = pin.getFrameVelocity(first.model, first.data, first.frame, AXES)
        rate = pin.getFrameClassicalAcceleration(first.model, first.data, first.frame, AXES)
        w, dw = R @ twist.angular, R @ rate.angular
        a = R @ rate.linear - np.cross(dw, r) - np.cross(w, np.cross(w, r))
        I_w = pose.rotation @ reference.inertia @ pose.rotation.T
        taken = np.concatenate([reference.mass * (a - reference.gravity), I_w @ dw + np.cross(w, I_w @ w)])
        size = np.max(np.abs(taken))
        assert np.max(np.abs((needed - taken)[reference.rows])) <= ROUNDING * size


def test_no_limit_is_passed_at_any_tick(played):
    override, states, _ = played
    assert np.max(passed(override.cell, states)) <= FOLLOWED
    np.testing.assert_allclose(
        np.maximum(override.tables.excess(states), -1), np.max(others(override.cell, states), axis=1)
    )
    assert np.min(states["speed"]) >= 0
    assert np.all(np.diff(states["time"]) >= 0)


@pytest.mark.quick
def test_what_is_no_place_speed_or_state_of_this_override_is_refused(slow_lift):
    override = mrts.SpeedOverride(slow_lift)
    here = override.start(0.1, 0.5)
    elsewhere = mrts.SpeedOverride(mrts.scale(*shipped_motion_of("dual_ur5"), 0.3)).start(0.3)
    wrong = {
        "time": [lambda: override.start(-0.1), lambda: override.start(np.nan), lambda: override.start("0")],
        "speed": [lambda: override.start(0.1, 1.5), lambda: override.start(0.1, -0.5)],
        "wanted": [lambda: override.step(here, np.nan), lambda: override.step(here, None)],
        "dt": [
            lambda: override.step(here, 1.0, 0.0),
            lambda: override.play(np.ones(2), -1.0),
            lambda: override.stop_time(here, 0.0),
            lambda: override.speed_for_stop(here, 1.0, np.nan),
        ],
        "q": [lambda: override.resume(here.q[:2], 0.1), lambda: override.resume(here.q + 1, 0.1)],
        "result": [lambda: mrts.SpeedOverride(slow_lift.motion)],
        "state": [
            lambda: override.step(elsewhere, 1.0),
            lambda: override.play(np.ones(2), state=elsewhere),
            lambda: override.stop_time(elsewhere),
            lambda: override.speed_for_stop(elsewhere, 1.0),
            lambda: override.step(None, 1.0),
        ],
        "seconds": [lambda: override.speed_for_stop(here, np.nan), lambda: override.speed_for_stop(here, -1.0)],
        "within": [lambda: override.resume(here.q, "near"), lambda: override.resume(here.q, np.nan)],
    }
    for key, calls in wrong.items():
        for call in calls:
            with pytest.raises(mrts.InputError) as refused:
                call()
            assert refused.value.key == key or str(refused.value).startswith(key)
    again = override.resume(here.q + 1e-4, 1e-3)
    assert again.time == pytest.approx(here.time, abs=1e-3)
    assert again.speed == 0.0


def test_it_ends_at_rest_where_the_plan_ends(played):
    override, _, _ = played
    last = override.play(np.ones(3000))[-1]
    assert (last["time"], last["finished"]) == (override.duration, 1)
    assert not np.any([last["dq"], last["ddq"]])
    assert np.array_equal(last["q"], override.tables.nodes["q"][-1])


def test_a_stop_takes_what_is_promised(played):
    override, states, _ = played
    for k in (100, 300, 600):
        state = override.start(float(states["time"][k]), float(states["speed"][k]))
        promised = override.stop_time(state)
        ticks = override.play(np.zeros(2000), state=state)["speed"]
        assert promised == pytest.approx(1e-3 * (1 + np.argmax(ticks == 0)) * (state.speed > 0))
        speed = override.speed_for_stop(state, 0.01)
        slower = override.start(state.time, speed)
        assert override.stop_time(slower) <= 0.01 + 1e-12


def test_rates_are_kept_where_they_are_asked_for():
    cell, motion = shipped_motion_of("dual_ur5")
    result = mrts.retime(cell, motion, rates=10)
    override = mrts.SpeedOverride(result, rates=40)
    size = 40 * np.concatenate([robot.torque_upper for robot in cell.robots])
    for seed in range(4):
        states = override.play(np.append(wishes(np.random.default_rng(seed), 700), np.ones(1500)))
        change = np.abs(np.diff(states["torque"][states["finished"] == 0], axis=0)) / 1e-3
        assert np.max(change / size) <= 1 + FOLLOWED
        assert np.max(states["time"]) == override.duration
    assert 0.05 < np.max(override.stops().stop_time) < 0.12
    assert np.max(mrts.SpeedOverride(result).stops().stop_time) <= 0.03  # without rates
    with pytest.raises(mrts.InputError, match="too little of its limits of rates"):
        mrts.SpeedOverride(result, rates=10)


def test_it_runs_faster_than_the_plan_and_back():
    override = mrts.SpeedOverride(mrts.scale(*shipped_motion_of("dual_ur5")), fastest=1.3, backwards=True)
    there = override.play(np.full(1000, 1.3))
    assert np.max(there["speed"]) == pytest.approx(1.3)
    assert np.sum(there["finished"] == 0) < 0.95 * override.duration / 1e-3
    back = override.play(np.full(1000, -1.0), state=override.start(override.duration))
    assert (back["time"][-1], back["finished"][-1]) == (0.0, 1)
    for states in (there, back):
        assert np.max(override.tables.excess(states)) <= FOLLOWED


@pytest.mark.quick
def test_a_largest_speed_that_is_the_same_everywhere_is_a_speed(slow_lift):
    override = mrts.SpeedOverride(slow_lift, fastest=1.2)
    assert np.ptp(override.tables.nodes["most"]) == 0
    states = override.play(np.random.default_rng(0).uniform(0, 2, 4000))
    assert np.max(states["speed"]) == pytest.approx(1.2)
    assert np.max(override.tables.excess(states)) <= BETWEEN


@pytest.mark.quick
def test_at_rest_at_an_end_nothing_changes_until_it_is_left(slow_lift):
    override = mrts.SpeedOverride(slow_lift, backwards=True)
    back = override.play(np.full(400, -1.0), state=override.start(0.02))
    arrived = int(np.argmax(back["finished"]))
    assert np.all(back["finished"][arrived:] == 1)
    assert not np.any(np.ptp(back["torque"][arrived:], axis=0))
    assert not np.any(back["active"][arrived:])
    away = override.play(np.full(3000, 1.0), state=override.start(0.02))
    assert np.max(away["time"]) == override.duration


@pytest.mark.slow
@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("name", CELLS)
def test_a_million_ticks_of_random_wishes(name, profile):
    override, rng = played_plan(name, profile), np.random.default_rng(33)
    states, begins = drawn_ticks(override, rng, TICKS)
    places = [override.start(time, 1.0).numbers for time in rng.uniform(0, override.duration, 2000)]
    plan = max(np.max(passed(override.cell, np.array(places))), 0.0)
    assert np.max(passed(override.cell, states)) <= plan + BETWEEN
    assert np.min(states["speed"]) >= 0
    back = np.setdiff1d(np.flatnonzero(np.diff(states["time"]) < 0) + 1, begins)
    assert not back.size
    for k in rng.integers(0, TICKS, 200):
        state = override.start()
        state.numbers[...] = states[k]
        promised = round(override.stop_time(state) / 1e-3)
        stop = override.play(np.zeros(promised + 20), state=state)
        assert not np.any(stop["speed"][promised:])
        assert np.ptp(stop["time"][promised:]) == 0
    end = override.play(np.ones(5000), state=state)[-1]
    assert (end["time"], end["finished"], end["speed"]) == (override.duration, 1, 0)
    assert not np.any([end["dq"], end["ddq"]])


@pytest.mark.parametrize("name", ["planar_dual_arm with motors", "three_arms"])
def test_a_constant_wish_plays_what_scale_finds_at_that_factor(name):
    cell, motion = shipped_motion_of(name)
    plan = mrts.scale(cell, motion)
    override = mrts.SpeedOverride(plan)
    for wish in (0.3, 0.7):
        slower = mrts.scale(cell, motion, (wish * plan.trajectory.c) ** 2).trajectory
        assert slower.time[-1] == pytest.approx(override.duration / wish, rel=ROUNDING)
        states = np.array([override.start(wish * time, wish).numbers for time in slower.time[:-1]])
        for name_of in ("q", "dq", "ddq"):
            given = getattr(slower, name_of)
            assert np.max(np.abs(states[name_of] - given[:-1])) <= ROUNDING * np.max(np.abs(given))
        assert np.max(passed(cell, states)) <= BETWEEN
        ticks = override.play(np.full(100, wish), 1e-3, override.start(0.0, wish))
        assert np.max(np.abs(ticks["time"] - wish * 1e-3 * np.arange(1, 101))) <= ROUNDING


@pytest.mark.slow
@pytest.mark.parametrize("profile", PROFILES)
def test_whatever_load_of_the_box_it_is_can_be_carried(profile):
    override, rng = played_plan("uncertain_load", profile), np.random.default_rng(4)
    cell, states = override.cell, drawn_ticks(override, rng, 2000)[0][::4]
    corners = np.array([point.load for point in cell.load_box.corners()])
    inside = rng.dirichlet(np.ones(len(corners)), 6) @ corners
    rows = motion_rows(cell, carried(cell, states), None)
    for load in (*corners, *inside):
        assert np.max(motion_widening(rows, np.ones(len(states)), load)) <= BETWEEN


SEARCHED = [("dual_ur5", "fastest"), ("squeeze", "smooth"), ("planar_dual_arm with motors", "constant")]

KNOTS, LASTS = 30, 480
"""Of a wish that a search changes, and how many ticks it lasts."""


@pytest.mark.slow
@pytest.mark.parametrize(("name", "profile"), SEARCHED)
def test_a_search_finds_no_wish_that_passes_a_limit(name, profile):
    """The share that is passed grows by evolution, then knot by knot, from several states."""
    override, rng = played_plan(name, profile), np.random.default_rng(6)
    places = [override.start(time, 1.0).numbers for time in rng.uniform(0, override.duration, 2000)]
    plan = max(np.max(passed(override.cell, np.array(places))), 0.0)
    for restart in range(4):
        first = override.start(rng.uniform(0, 0.6 * override.duration), rng.uniform(0, 1)) if restart else None

        def worst(wish, state=first):
            return np.max(passed(override.cell, override.play(np.repeat(wish, LASTS // KNOTS), state=state)))

        best = mean = rng.choice([0.0, 0.5, 1.0, 1.5], KNOTS)
        found, spread = worst(best), np.full(KNOTS, 0.5)
        for _ in range(10):
            drawn = mean + spread * rng.normal(size=(8, KNOTS))
            shares = np.array([worst(wish) for wish in drawn])
            order = np.argsort(-shares)
            if shares[order[0]] > found:
                best, found = drawn[order[0]], shares[order[0]]
            mean = (mean + np.mean(drawn[order[:3]], axis=0)) / 2
            spread = 0.8 * spread + 0.2 * np.std(drawn[order[:3]], axis=0) + 0.02
        for knot in rng.permutation(KNOTS):
            for speed in (0.0, 0.5, 1.5):
                other = best.copy()
                other[knot] = speed
                if (share := worst(other)) > found:
                    best, found = other, share
        assert found <= plan + BETWEEN


@pytest.mark.quick
def test_samples_that_do_not_tell_what_is_between_have_no_override(tmp_path):
    """At the turning point the object waits, and its samples accelerate all the time."""
    plan = mrts.scale(gantries(tmp_path), there_and_back(0.5, wait=5))
    with pytest.raises(mrts.InputError, match=r"^result"):
        mrts.SpeedOverride(plan)


@pytest.mark.quick
def test_an_internal_wrench_of_each_sample_has_no_override():
    cell, motion = shipped_motion_of("planar_dual_arm")
    given = [np.zeros((len(motion.time), 6)), np.zeros(6)]
    known, fixed = (mrts.scale(cell, motion, sharing=mrts.LoadSharing(internal_wrench=of)) for of in given)
    with pytest.raises(mrts.InputError, match=r"^result"):
        mrts.SpeedOverride(known)
    override = mrts.SpeedOverride(fixed)
    assert np.max(passed(override.cell, override.play(np.ones(500)))) <= BETWEEN


@pytest.mark.quick
def test_where_a_cup_needs_speed_there_is_no_override(tmp_path):
    """Around a vertical circle from its lowest point, inward up: above it only swinging keeps the cup on."""
    time = np.linspace(0.0, 1.0, 201)
    turned, speed, rate = 2 * np.pi * np.array(quintic(time))
    motion = loop(time, turned - np.pi, speed, rate)
    strong = {"torque_lower": np.full(3, -1e6), "torque_upper": np.full(3, 1e6), "posture": np.array([0, 0, 2 * np.pi])}
    cell = with_robots(gantries(tmp_path, gravity=(0, -9.81, 0)), **strong)
    cup = CarriedThing(name="cup", normal=[0, 1, 0], friction=1.5)
    plan = mrts.scale(replace(cell, carried=(cup,), object_acceleration_limit=np.array([900.0, np.inf])), motion)
    assert plan.range.lower.c2 > 0
    with pytest.raises(mrts.InputError, match="object/cup"):
        mrts.SpeedOverride(plan)

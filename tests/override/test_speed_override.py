"""A plan at a speed that changes: Pinocchio's torques, every limit at every tick, and stops within what is promised."""

import numpy as np
import pinocchio as pin
import pytest
from random_cells import configuration
from random_motors import equipped
from reference import ReferenceCell
from shipped_cells import DATA

import mrts

ROUNDING = 1e-9
"""Largest difference to Pinocchio's torques, as a share of a torque limit."""

BETWEEN = 1e-3
"""Share of a limit by which a plan that was followed between its samples to 1e-4 is passed at most at a tick."""

AXES = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

PLANS = {
    "planar fastest": ("planar_dual_arm", "lift", {}),
    "dual constant": ("dual_ur5", "lift_and_turn", None),
    "dual smooth": ("dual_ur5", "lift_and_turn", {"rates": 10}),
    "squeeze constant": ("squeeze", "lift_and_turn", None),
    "motors fastest": ("planar_dual_arm", "lift", {}),
}
MOTORS = {"armature": [0.5, 0.4, 0.1], "coulomb": [6, 5, 2], "viscous": [8, 8, 3]}


@pytest.fixture(scope="module", params=PLANS)
def played(request):
    """A plan, and a thousand wishes that it was played by."""
    name, motion, rates = PLANS[request.param]
    cell, given = mrts.load_cell(DATA / name / "cell.yaml"), mrts.load_motion(DATA / name / f"{motion}.yaml")
    cell = equipped(cell, **MOTORS) if request.param.startswith("motors") else cell
    result = mrts.scale(cell, given) if rates is None else mrts.retime(cell, given, **rates)
    override = mrts.SpeedOverride(result)
    return override, override.play(wishes(np.random.default_rng(1), 1000)), DATA / name / "cell.yaml"


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
    cell = override.cell
    for part, lower, upper in (("torque", "torque_lower", "torque_upper"), ("wrench", "wrench_lower", "wrench_upper")):
        low, high = (np.concatenate([getattr(robot, name) for robot in cell.robots]) for name in (lower, upper))
        finite = np.isfinite(high) & np.isfinite(low)
        value, low, high = states[part][:, finite], low[finite], high[finite]
        assert np.max((value - high) / high, initial=0.0) <= BETWEEN
        assert np.max((low - value) / -low, initial=0.0) <= BETWEEN
    velocity = np.concatenate([robot.velocity_limit for robot in cell.robots])
    assert np.max(np.abs(states["dq"]) / velocity) <= 1 + BETWEEN
    assert np.max(override.excess(states)) <= BETWEEN  # contacts and the motion alone besides
    assert np.min(states["speed"]) >= 0
    assert np.all(np.diff(states["time"]) >= 0)


@pytest.mark.quick
def test_what_is_no_place_or_speed_is_refused():
    folder = DATA / "planar_dual_arm"
    given = mrts.load_motion(folder / "lift.yaml")
    override = mrts.SpeedOverride(mrts.scale(mrts.load_cell(folder / "cell.yaml"), given))
    here = override.start(0.1, 0.5)
    wrong = {
        "time": [lambda: override.start(-0.1), lambda: override.start(np.nan), lambda: override.start("0")],
        "speed": [lambda: override.start(0.1, 1.5), lambda: override.start(0.1, -0.5)],
        "wanted": [lambda: override.step(here, np.nan), lambda: override.step(here, None)],
        "dt": [lambda: override.step(here, 1.0, 0.0), lambda: override.play(np.ones(2), -1.0)],
        "q": [lambda: override.resume(here.q[:2], 0.1), lambda: override.resume(here.q + 1, 0.1)],
        "result": [lambda: mrts.SpeedOverride(given)],
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
    assert np.array_equal(last["q"], override.nodes["q"][-1])


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
    name, motion, rates = PLANS["dual smooth"]
    cell, given = mrts.load_cell(DATA / name / "cell.yaml"), mrts.load_motion(DATA / name / f"{motion}.yaml")
    result = mrts.retime(cell, given, **rates)
    override = mrts.SpeedOverride(result, rates=40)
    size = 40 * np.concatenate([robot.torque_upper for robot in cell.robots])
    for seed in range(4):
        states = override.play(np.append(wishes(np.random.default_rng(seed), 700), np.ones(1500)))
        change = np.abs(np.diff(states["torque"][states["finished"] == 0], axis=0)) / 1e-3
        assert np.max(change / size) <= 1 + BETWEEN
        assert np.max(states["time"]) == override.duration
    longest = np.max(override.stops().stop_time)
    assert 0.05 < longest < 0.12  # 22 ms where rates are not kept
    with pytest.raises(mrts.InputError, match="too little of its limits of rates"):
        mrts.SpeedOverride(result, rates=10)


def test_it_runs_faster_than_the_plan_and_back():
    folder = DATA / "dual_ur5"
    result = mrts.scale(mrts.load_cell(folder / "cell.yaml"), mrts.load_motion(folder / "lift_and_turn.yaml"))
    override = mrts.SpeedOverride(result, fastest=1.3, backwards=True)
    there = override.play(np.full(1000, 1.3))
    assert np.max(there["speed"]) == pytest.approx(1.3)
    assert np.sum(there["finished"] == 0) < 0.95 * override.duration / 1e-3
    state = override.start(override.duration)
    back = override.play(np.full(1000, -1.0), state=state)
    assert (back["time"][-1], back["finished"][-1]) == (0.0, 1)
    for states in (there, back):
        assert np.max(override.excess(states)) <= BETWEEN


def test_from_full_speed_the_dual_cell_stops_within_30_ms():
    name, motion, rates = PLANS["dual smooth"]
    result = mrts.retime(
        mrts.load_cell(DATA / name / "cell.yaml"), mrts.load_motion(DATA / name / f"{motion}.yaml"), **rates
    )
    override = mrts.SpeedOverride(result)
    places = np.linspace(0.0, override.duration * 0.999, 200)
    assert max(override.stop_time(override.start(float(time), 1.0)) for time in places) <= 0.03

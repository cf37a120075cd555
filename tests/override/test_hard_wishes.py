"""Wishes that try a speed override: random, the worst that a search finds, other loads, and what is no wish at all."""

from dataclasses import replace

import numpy as np
import pytest
from changed_robots import with_robots
from gantries import gantries, there_and_back
from random_motors import equipped
from shipped_cells import DATA

import mrts
from mrts.cell.points import CarriedThing
from mrts.following.coordinated_motion import carried_by_first
from mrts.limits import limit_rows
from mrts.program.motion_rows import motion_rows
from mrts.program.widening import motion_widening

ROUNDING = 1e-9

BETWEEN = 2e-4
"""Share of a limit by which a tick may pass it: twice what tables are made to, for places where nobody looked."""


def shipped_motion_of(name):
    """A shipped cell and its motion."""
    folder = DATA / name
    motion = next(path for path in (folder / "lift.yaml", folder / "lift_and_turn.yaml") if path.exists())
    return mrts.load_cell(folder / "cell.yaml"), mrts.load_motion(motion)


@pytest.fixture(scope="module")
def slow_lift():
    """A plan far below what limits allow."""
    return mrts.scale(*shipped_motion_of("planar_dual_arm"), 0.3)


@pytest.mark.quick
def test_a_largest_speed_that_is_the_same_everywhere_is_a_speed(slow_lift):
    override = mrts.SpeedOverride(slow_lift, fastest=1.2)
    assert np.ptp(override.nodes["most"]) == 0
    states = override.play(np.random.default_rng(0).uniform(0, 2, 4000))
    assert np.max(states["speed"]) == pytest.approx(1.2)
    assert np.max(override.excess(states)) <= BETWEEN


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


@pytest.mark.quick
def test_what_is_no_state_or_time_of_this_override_is_refused(slow_lift):
    override = mrts.SpeedOverride(slow_lift)
    longer = mrts.SpeedOverride(mrts.scale(*shipped_motion_of("dual_ur5"), 0.3))
    here, elsewhere = override.start(0.1), longer.start(0.3)
    wrong = {
        "state": [
            lambda: override.step(elsewhere, 1.0),
            lambda: override.play(np.ones(2), state=elsewhere),
            lambda: override.stop_time(elsewhere),
            lambda: override.speed_for_stop(elsewhere, 1.0),
            lambda: override.step(None, 1.0),
        ],
        "dt": [lambda: override.stop_time(here, 0.0), lambda: override.speed_for_stop(here, 1.0, np.nan)],
        "seconds": [lambda: override.speed_for_stop(here, np.nan), lambda: override.speed_for_stop(here, -1.0)],
        "within": [lambda: override.resume(here.q, "near"), lambda: override.resume(here.q, np.nan)],
    }
    for key, calls in wrong.items():
        for call in calls:
            with pytest.raises(mrts.InputError) as refused:
                call()
            assert refused.value.key == key or str(refused.value).startswith(key)


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


def played_plan(name, profile):
    """The override of a cell's plan."""
    cell, motion = shipped_motion_of(name.split(" ")[0])
    cell = equipped(cell, **MOTORS) if name.endswith("motors") else cell
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
    count = np.arange(len(states), dtype=float)
    parts = (np.array(states[name]) for name in ("q", "dq", "ddq"))
    rows = limit_rows(cell, carried_by_first(cell, count, *parts))
    others = rows.excess(rows.value(np.array(states["torque"]), np.array(states["wrench"]), 0.0, 1.0))
    return np.max([*found, np.max(others, axis=1)], axis=0)


def drawn_ticks(override, rng, count):
    """States after ticks of all lengths: steps, ramps, stops, wishes beyond what is allowed, joins and resumes.

    Returns:
        States, and where each run begins.
    """
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
    cell, motion = shipped_motion_of(name.split(" ")[0])
    cell = equipped(cell, **MOTORS) if name.endswith("motors") else cell
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
    parts = (np.array(states[name]) for name in ("q", "dq", "ddq"))
    motion = carried_by_first(cell, np.arange(len(states), dtype=float), *parts)
    rows = motion_rows(cell, motion, None)
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
    with pytest.raises(mrts.InputError) as refused:
        mrts.SpeedOverride(plan)
    assert str(refused.value).startswith("result")


@pytest.mark.quick
def test_an_internal_wrench_of_each_sample_has_no_override():
    cell, motion = shipped_motion_of("planar_dual_arm")
    given = [np.zeros((len(motion.time), 6)), np.zeros(6)]
    known, fixed = (mrts.scale(cell, motion, sharing=mrts.LoadSharing(internal_wrench=of)) for of in given)
    with pytest.raises(mrts.InputError) as refused:
        mrts.SpeedOverride(known)
    assert str(refused.value).startswith("result")
    override = mrts.SpeedOverride(fixed)
    assert np.max(passed(override.cell, override.play(np.ones(500)))) <= BETWEEN


@pytest.mark.quick
def test_where_a_cup_needs_speed_there_is_no_override(tmp_path):
    """Around a vertical circle from its lowest point, inward up: above it only swinging keeps the cup on."""
    time, radius = np.linspace(0.0, 1.0, 201), 0.5
    turned, speed, rate = (
        2
        * np.pi
        * np.array(
            [
                10 * time**3 - 15 * time**4 + 6 * time**5 - 0.5,
                30 * time**2 - 60 * time**3 + 30 * time**4,
                60 * time - 180 * time**2 + 120 * time**3,
            ]
        )
    )
    none, up = np.zeros_like(time), np.tile([0.0, 0.0, 1.0], (len(time), 1))
    out = np.column_stack([np.sin(turned), np.cos(turned), none])
    along = np.column_stack([np.cos(turned), -np.sin(turned), none])
    twist, acceleration = np.zeros((2, len(time), 6))
    twist[:, :3], twist[:, 5] = radius * speed[:, None] * along, -speed
    acceleration[:, :3] = radius * (rate[:, None] * along - (speed**2)[:, None] * out)
    acceleration[:, 5] = -rate
    motion = mrts.ObjectMotion(time, radius * out, np.stack([-along, -out, up], axis=2), twist, acceleration)
    strong = {"torque_lower": np.full(3, -1e6), "torque_upper": np.full(3, 1e6), "posture": np.array([0, 0, 2 * np.pi])}
    cell = with_robots(gantries(tmp_path, gravity=(0, -9.81, 0)), **strong)
    cup = CarriedThing(name="cup", normal=[0, 1, 0], friction=1.5)
    plan = mrts.scale(replace(cell, carried=(cup,), object_acceleration_limit=np.array([900.0, np.inf])), motion)
    assert plan.range.lower.c2 > 0
    with pytest.raises(mrts.InputError) as refused:
        mrts.SpeedOverride(plan)
    assert str(refused.value).startswith("result")
    assert "object/cup" in str(refused.value)

"""A limit given to a cell, whatever its columns, holds wherever limits count."""

import re
from dataclasses import replace

import numpy as np
import pytest
from changed_robots import with_left
from scipy.optimize import linprog

import mrts
from mrts.cell.robot import JointMotors
from mrts.limits import limit_rows
from mrts.limits.cell_limits import motor_limits, torque_limits
from mrts.limits.rows import LimitRows
from mrts.output.embedded_tables import embedded_tables
from mrts.program.motion_rows import binds, motion_rows

CURVE = np.array([[0.0, 90.0], [2.0, 90.0], [4.0, 60.0], [5.0, 10.0]])


@pytest.mark.quick
def test_rows_hold_exactly_what_the_curve_admits(planar_cell, lift):
    """By membership, with the plain limits of the torque: 10⁴ torques and speeds in both directions."""
    motors, limit = replace(JointMotors.unknown(3), torque_speed=(CURVE, None, None)), np.array([90.0, 80.0, 50.0])
    cell = with_left(planar_cell, motors=motors, torque_lower=-limit, torque_upper=limit)
    motion = mrts.follow_object(planar_cell, lift)
    rows = motor_limits(cell, motion)
    assert [name.kind for name in rows.names] == ["torque-speed", "torque-speed", "motor speed"]
    rng, joints = np.random.default_rng(3), motion.q.shape[1]
    for _ in range(100):
        torque, speed = np.zeros((motion.samples, joints)), rng.uniform(0, 12)
        torque[:, 0] = rng.uniform(-90, 90, motion.samples)
        value = rows.value(torque, np.zeros((motion.samples, 6)), 0.0, speed)
        kept = np.all((value >= rows.limits.lower) & (value <= rows.limits.upper), axis=1)
        velocity = speed * motion.dq[:, 0]
        most = np.interp(np.abs(velocity), CURVE[:, 0], CURVE[:, 1])
        drives = torque[:, 0] * velocity > 0
        admitted = (np.abs(velocity) <= 5.0) & (~drives | (np.abs(torque[:, 0]) <= most))
        assert np.array_equal(kept, admitted)


pytestmark = pytest.mark.quick

KEPT = 1 + 1e-7  # of a limit: rounding, and the slack of the quadratic programs
SAME = 1e-7  # relative: two solvers, and an oracle with other unknowns
ADDED_INERTIA = 20.0  # [kg m²] of the torque that grows with the square of a joint's speed
MASS = 3.0  # [kg] of the kinetic energy


def shoulder_and_elbow(_motion, torque, _dq, _ddq):
    return torque[:, 0] + torque[:, 1]


def torque_and_square(_motion, torque, dq, _ddq):
    return torque[:, 0] + ADDED_INERTIA * dq[:, 0] ** 2


def kinetic_energy(motion, _torque, dq, _ddq):
    given = np.max(np.abs(motion.dq), axis=1)
    c2 = np.divide(np.max(np.abs(dq), axis=1) ** 2, given**2, out=np.zeros_like(given), where=given > 0)
    return MASS / 2 * np.sum(motion.object.twist[:, :3] ** 2, axis=1) * c2


def acceleration(_motion, _torque, _dq, ddq):
    return ddq[:, 1]


def columns_of(kind, motion):
    """Columns of each of the quantities above in a row."""
    torques = np.zeros((1, motion.dq.shape[1]))
    if kind == "sum of torques":
        torques[0, :2] = 1
        return torques, {}
    if kind == "torque and square":
        torques[0, 0] = 1
        return torques, {"square": ADDED_INERTIA * motion.dq[:, :1] ** 2}
    if kind == "kinetic energy":
        return torques, {"square": MASS / 2 * np.sum(motion.object.twist[:, :3] ** 2, axis=1)[:, None]}
    return torques, {"rate": motion.dq[:, 1:2], "square": motion.ddq[:, 1:2]}


QUANTITIES = {
    "sum of torques": shoulder_and_elbow,
    "torque and square": torque_and_square,
    "kinetic energy": kinetic_energy,
    "acceleration": acceleration,
}


def limited(given, kind, limit):
    """A cell with one more limit, alike in both directions."""

    def more(cell, motion):
        torques, columns = columns_of(kind, motion)
        sides = {"lower": np.array([-limit]), "upper": np.array([limit])}
        names = [mrts.RowName(kind, "left", "mine", "X")]
        return LimitRows.of(cell, names=names, **sides, torque_matrix=torques, **columns)

    return given.with_limits(more)


def largest(kind, result):
    done = result.trajectory
    return float(np.max(np.abs(QUANTITIES[kind](result.motion, done.torque, done.dq, done.ddq))))


@pytest.fixture(params=QUANTITIES)
def kind(request):
    return request.param


@pytest.fixture
def limit(kind, planar_cell, lift):
    """Less than what the fastest motion makes of it, so that it counts."""
    return 0.7 * largest(kind, mrts.scale(planar_cell, lift))


def by_oracle(cell, motion, sample, kind, limit):
    """Largest c² of a sample from the terms of the dynamics, with all torques, wrenches and c² as unknowns."""
    terms = {
        name: value[sample] for name, value in cell.functions("terms", motion.samples, motion.inputs(cell.load)).items()
    }
    joints, wrenches = motion.dq.shape[1], terms["B"].shape[1]
    torques, columns = columns_of(kind, motion)
    laws = np.zeros((joints + len(terms["P"]), joints + wrenches + 1))
    laws[:joints, :joints], laws[:joints, -1] = np.eye(joints), -terms["E"]
    for name, part in cell.joint_slices.items():
        where = cell.wrench_slices[name]
        laws[part, joints + where.start : joints + where.stop] = -terms["J"][:, part].T
    laws[joints:, joints:-1], laws[joints:, -1] = terms["B"], -terms["P"]
    row = np.concatenate([torques[0], np.zeros(wrenches), columns.get("square", np.zeros((motion.samples, 1)))[sample]])
    bounds = [pair for arm in cell.robots for pair in zip(arm.torque_lower, arm.torque_upper, strict=True)]
    bounds += [pair for arm in cell.robots for pair in zip(arm.wrench_lower, arm.wrench_upper, strict=True)]
    cost = np.append(np.zeros(joints + wrenches), -1.0)
    sides, right = np.stack([row, -row]), np.concatenate([terms["G"], terms["Q"]])
    found = linprog(cost, sides, [limit, limit], laws, right, [*bounds, (0, None)])
    return found.x[-1]


@pytest.mark.quick
def test_the_range_and_the_torques_keep_it(kind, limit, planar_cell, lift):
    free, cell = mrts.scale(planar_cell, lift), limited(planar_cell, kind, limit)
    ours, theirs = (mrts.scale(cell, lift, solver=solver) for solver in ("kernel", "qpsol:qpoases"))
    assert largest(kind, ours) <= limit * KEPT
    assert ours.range.upper.c2 <= free.range.upper.c2
    for end in ("lower", "upper"):
        one, other = getattr(ours.range.samples, end), getattr(theirs.range.samples, end)
        np.testing.assert_allclose(one, other, rtol=SAME)
    moving = range(10, 100, 15)
    expected = [by_oracle(cell, ours.motion, sample, kind, limit) for sample in moving]
    np.testing.assert_allclose(ours.range.samples.upper[moving], expected, rtol=SAME)
    np.testing.assert_allclose(theirs.trajectory.torque, ours.trajectory.torque, atol=1e-5)


def test_retiming_keeps_it(kind, limit, planar_cell, lift):
    free = mrts.retime(planar_cell, lift)
    found = mrts.retime(limited(planar_cell, kind, limit), lift)
    done = found.retimed.trajectory
    value = QUANTITIES[kind](found.retimed.motion, done.torque, done.dq, done.ddq)
    assert np.max(np.abs(value)) <= limit * KEPT
    assert found.duration >= free.duration * (1 - SAME)
    if kind != "sum of torques":  # the arms may push against each other instead
        assert found.duration > free.duration
        assert any(kind in name for name, _ in found.limits)


def test_limits_of_the_speed_alone_are_squared_exactly(planar_cell, lift):
    """By membership: b ṙ is between its limits where the squared row is."""
    rng, count = np.random.default_rng(5), 60
    lower = rng.choice([-np.inf, -2.0, -0.5, 0.0, 0.3], count)
    upper = rng.choice([np.inf, 2.0, 0.5, 0.4], count)
    speed = rng.normal(size=(len(lift.time), count)) * (rng.random((len(lift.time), count)) < 0.8)
    names = [mrts.RowName("any", "arm", str(row), "m/s") for row in range(count)]
    cell = planar_cell.without_velocity_limits().with_limits(
        lambda cell, _motion: LimitRows.of(cell, names=names, lower=lower, upper=upper, speed=speed)
    )
    form = motion_rows(cell, mrts.follow_object(planar_cell, lift))
    ours = np.array([name.kind == "any" for name in form.given.names])
    none = np.zeros((len(lift.time), 6)), np.zeros((len(lift.time), 6))
    for c in rng.uniform(0, 3, 50):
        inside = (form.given.excess(form.given.value(*none, 0.0, c)) <= 0)[:, ours]
        np.testing.assert_array_equal((form.rows.excess(form.rows.value(*none, 0.0, c)) <= 0)[:, ours], inside)
        np.testing.assert_array_equal(c**2 <= form.most, np.all(inside[:, form.is_cap[ours]], axis=1))
    assert 0 < np.count_nonzero(form.is_cap) < count
    assert set(np.sign(form.rows.square[:, form.is_cap][binds(form.cap_share)])) == {-1, 1}


def test_what_is_the_same_along_any_motion_is_made_once_and_stays_so(planar_cell, lift):
    motion = mrts.follow_object(planar_cell, lift)
    limits = [limit_rows(planar_cell, of).limits for of in (motion, motion.at(slice(0, 50)))]
    assert limits[0] is limits[1]
    for given in (torque_limits(planar_cell).limits, *limits):
        assert not any(getattr(given, name).flags.writeable for name in ("lower", "upper", "torque_matrix"))


def of_limits(rows, **values):
    return replace(rows, limits=replace(rows.limits, **values))


WRONG_ROWS = {
    "a shape": (
        lambda rows: replace(rows, square=rows.square[:, :1]),
        "square: must be real numbers of shape (101, 2)",
    ),
    "names": (lambda rows: of_limits(rows, names=rows.names[:1]), "lower: must be real numbers of shape (1,)"),
    "a number": (lambda rows: of_limits(rows, lower=-2.0), "lower: must be real numbers of shape (2,)"),
    "NaN": (
        lambda rows: of_limits(rows, upper=np.array([2.0, np.nan])),
        "upper: object/y acceleration: must be finite",
    ),
    "infinite": (
        lambda rows: replace(rows, square=np.where(np.arange(101)[:, None] == 50, np.inf, rows.square)),
        "square: object/x acceleration at sample 50: must be finite",
    ),
    "reversed": (
        lambda rows: of_limits(rows, lower=rows.limits.upper, upper=rows.limits.lower),
        "lower, upper: object/x acceleration: no number is from 2 to -2",
    ),
    "nothing": (lambda _rows: None, "must give LimitRows, not NoneType"),
    "text": (lambda rows: of_limits(rows, names=("x", "y")), "names: must name its rows by RowName"),
    "a polygon": (
        lambda rows: of_limits(rows, names=tuple(replace(name, sides=4) for name in rows.names)),
        "names: must name its rows by RowName, without sides",
    ),
}


@pytest.mark.parametrize("wrong", WRONG_ROWS)
def test_a_limit_that_gives_no_rows_of_this_motion_is_named(wrong, planar_cell, lift):
    change, message = WRONG_ROWS[wrong]

    def splash(cell, motion):
        names = [mrts.RowName("acceleration", "object", axis, "m/s²") for axis in "xy"]
        sides = {"lower": np.full(2, -2.0), "upper": np.full(2, 2.0)}
        return change(LimitRows.of(cell, names=names, **sides, square=motion.object.acceleration[:, :2]))

    solvers = [mrts.scale, mrts.retime] + [embedded_tables] * (wrong in {"nothing", "text"})
    for solve in solvers:
        with pytest.raises(mrts.InputError, match=re.escape(f"limit 'splash': {message}")):
            solve(planar_cell.with_limits(splash), lift)

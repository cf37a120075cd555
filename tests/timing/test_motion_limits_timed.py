"""Timings within limits of the motion alone, against toppra, Drake and Ruckig; norms and cones in smooth timing."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import ruckig
import yaml
from cases import DUAL
from cases import one_arm as ur5_with_box
from cell_bank import drawn_until
from drake_timing import by_drake, derivatives, spline
from draws import seeds
from gantries import along_x, gantries
from one_arm import duration, motion_by_toppra, one_arm

import mrts
from mrts.cell.points import CarriedThing, PointLimit
from mrts.following.coordinated_motion import carried_by_first
from mrts.limits import limit_rows, motion_limits
from mrts.limits.motion_limits import norm_rows, object_point
from mrts.limits.rows import RowName
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.timing.fastest_profile import SpeedProfile, fastest_profile, speed_regions

CORNER, MOST = np.array([0.3, 0.4, 0.5]), 3.0
"""A point of the object, whose way is bent, and the largest size of its acceleration [m/s²]."""

ROUNDING = 1e-12


def sides_alone(cell, motion):
    """A row for each side of the polygon of its acceleration."""
    name = RowName("acceleration", "object", "corner", "m/s²")
    rows = norm_rows(cell, name, *object_point(motion, CORNER), MOST)
    return replace(rows, limits=replace(rows.limits, names=(name,) * len(rows.names)))


def test_smooth_timing_keeps_norms_themselves(dual_ur5, lift_and_turn, monkeypatch):
    """Polygons with more and more sides come near it, at the rate of their distance from the circle."""
    point = PointLimit(name="corner", point=tuple(CORNER), acceleration=MOST)
    best = mrts.retime(replace(dual_ur5, object_points=(point,)), lift_and_turn, rates=11.5, between=None)
    slower = []
    for sides in (224, 448, 896):
        monkeypatch.setattr(motion_limits, "NORM_SIDES", sides)
        inside = mrts.retime(dual_ur5, lift_and_turn, rates=11.5, limits=[sides_alone], between=None)
        slower.append(inside.duration / best.duration - 1)
    assert slower[0] > 1e-5
    assert slower[2] - (slower[1] - slower[2]) / 3 == pytest.approx(0, abs=1e-6)
    played = best.retimed.motion
    size = np.linalg.norm(object_point(played, CORNER)[1], axis=1)
    assert MOST * (1 - 2e-5) < np.max(size) <= MOST
    use = next(use for use in best.retimed.trajectory.limit_uses if use.name.element == "corner")
    assert use.largest == pytest.approx(np.max(size), rel=ROUNDING)
    assert use.share == pytest.approx(np.max(size) / MOST, rel=ROUNDING)


def test_a_cup_takes_all_of_its_friction(dual_ur5, lift_and_turn):
    cup = CarriedThing(name="cup", at=[0.1, 0.05, 0.05], normal=[0, 0.02, 1], friction=0.5)
    cell = replace(dual_ur5, carried=(cup,))
    timed = mrts.retime(cell, lift_and_turn, rates=11.5).retimed
    played = timed.motion
    turn = cup.axes @ played.object.rotation.transpose(0, 2, 1)
    a, b, n = np.einsum("nkj,nj->kn", turn, object_point(played, cup.centre)[1] - cell.gravity)
    beyond = (np.hypot(a, b) - cup.friction * n) / (cup.friction * 9.81)
    assert -1e-4 < np.max(beyond) <= 1e-9
    rows = limit_rows(cell, played)
    excess = rows.excess(rows.value(timed.trajectory.torque, timed.trajectory.wrench, 0.0, 1.0))
    cups = np.array([name.element == "cup friction" for name in rows.names])
    assert excess[:, cups] == pytest.approx(np.tile(beyond[:, None], (1, cups.sum())), rel=2e-4, abs=ROUNDING)


SAME_DURATION = 1e-5
"""Of two solvers on one grid, relative: seidel keeps limits to 1e-6 of their size."""

OTHER_SCHEME = 1e-3
"""Likewise, where Drake looks at the ends of a segment in another way: 4e-4 apart on 800 segments, less on more."""

SMOOTH = 3e-3
"""Likewise, where jerk is constant between nodes and switches at them."""

FAR = 1e6
"""Of a speed or an acceleration: no limit [m/s, m/s²]."""

AXES = np.eye(3)

STRONG = 1e6
"""Torques that bind nothing [N m]."""


def limited(cell, rng):
    """One arm with random limits of the motion of its joints alone."""
    limits = {"torque_lower": -np.full(6, STRONG), "torque_upper": np.full(6, STRONG)}
    limits |= {"velocity_limit": rng.uniform(0.5, 3, 6), "acceleration_upper": rng.uniform(1, 10, 6)}
    robot = replace(cell.robots[0], **limits, acceleration_lower=-rng.uniform(1, 10, 6))
    return replace(cell, robots=(robot,), enforces_velocity_limits=True)


def on_grid(cell, grid, joints):
    """Duration on the path's own parameter and the same grid as others, from q, q' and q''."""
    regions = speed_regions(
        build_sample_problem(motion_rows(cell, carried_by_first(cell, grid, *joints)), varying=True), 1.0
    )
    found = fastest_profile(np.diff(grid), regions, (0.0, 0.0))
    assert isinstance(found, SpeedProfile)
    return duration(np.diff(grid), found.x)


@pytest.mark.parametrize("seed", seeds(5, 45))
def test_velocities_and_accelerations_give_the_duration_of_toppra(seed, tmp_path):
    grid = np.linspace(0, 1, 201)
    cell, _, path = one_arm(seed, tmp_path)
    cell = limited(cell, np.random.default_rng([78, seed]))
    theirs = duration(np.diff(grid), motion_by_toppra(cell.robots[0], path, grid))
    ours = on_grid(cell, grid, [path(grid, order) for order in range(3)])
    assert ours == pytest.approx(theirs, rel=SAME_DURATION)


@pytest.fixture(scope="module")
def framed_arm(tmp_path_factory):
    """The arm of the shipped cell with a limited point on each of three links."""
    description = yaml.safe_load(
        replace(ur5_with_box(tmp_path_factory.mktemp("arm")), enforces_velocity_limits=True).to_yaml()
    )
    frames = [{"link": link, "point": [0.1, -0.15, 0.2], "speed": 1} for link in ("forearm", "wrist_2", "tool0")]
    description["robots"][0]["frames"] = frames
    return mrts.Cell.from_description(description)


class FrameCase:
    """An arm with limits of its joints and of one point of it, and a random path."""

    def __init__(self, seed, cell):
        self.rng, self.grid = np.random.default_rng(seed), np.linspace(0, 1, 801)
        self.cell = limited(cell, self.rng)
        self.robot = self.cell.robots[0]
        self.point = self.rng.choice(self.robot.point_limits)
        self.path = spline(np.linspace(0, 1, 5), self.robot.posture + self.rng.uniform(-0.8, 0.8, (5, 6)))
        speed, acceleration = self.rng.uniform([0.1, 0.2], [0.3, 0.5])
        self.limits = ((FAR, FAR), (speed, FAR), (FAR, acceleration), (FAR, acceleration / np.sqrt(3)))

    def ours(self, path, speed=None, acceleration=None):
        """Duration with limits of the point, by our rows."""
        point = self.point.model_copy(update={"speed": speed, "acceleration": acceleration})
        cell = replace(self.cell, robots=(replace(self.robot, point_limits=(point,)),))
        return on_grid(cell, self.grid, derivatives(path, self.grid))

    def theirs(self, path, speed, acceleration, axes=AXES):
        """Duration with the same speed and a box of accelerations, by Drake."""
        box = axes, np.broadcast_to(acceleration, 3)
        return by_drake(DUAL / "ur5_class_arm.urdf", self.robot, path, self.grid, self.point, speed, box)


def limiting(case):
    """What suits: durations with no limit of the point and with several, if Drake finds all and each costs 5 %."""
    free, *limited = durations = [case.theirs(case.path, *limits) for limits in case.limits]
    return durations if None not in durations and min(limited) > 1.05 * free else None


@pytest.mark.parametrize("seed", seeds(1, 9))
def test_points_on_random_paths_take_as_long_as_drake_says(seed, framed_arm):
    """The size of a velocity exactly; of an acceleration the ball is between two of Drake's boxes."""
    numbers = itertools.count()
    case, (_, theirs, wide, narrow) = drawn_until(limiting, lambda: FrameCase([seed, next(numbers)], framed_arm))
    (_, (speed, _), (_, acceleration), _), path = case.limits, case.path
    assert case.ours(path, speed=speed) == pytest.approx(theirs, rel=OTHER_SCHEME)
    assert wide < case.ours(path, acceleration=acceleration) < narrow


@pytest.mark.parametrize(
    ("velocity", "acceleration", "jerk"),
    [(np.inf, np.inf, 50.0), (1.2, np.inf, 50.0), (np.inf, 2.0, 20.0), (1.2, 2.0, 20.0), (1.0, 4.0, 8.0)],
)
def test_one_joint_with_jerk_takes_as_long_as_ruckig_says(velocity, acceleration, jerk, tmp_path):
    """From rest to rest along x; Ruckig's answer is a closed form."""
    given = ruckig.InputParameter(1)
    given.target_position = [2.0]
    given.max_velocity, given.max_acceleration, given.max_jerk = [velocity], [acceleration], [jerk]
    theirs = ruckig.Trajectory(1)
    assert ruckig.Ruckig(1).calculate(given, theirs) == ruckig.Result.Working
    cell = gantries(tmp_path)
    none = np.full(3, STRONG)
    slide = np.array([1.0, np.inf, np.inf])
    limits = {"velocity_limit": velocity * slide, "acceleration_lower": -acceleration * slide}
    limits |= {"acceleration_upper": acceleration * slide, "torque_lower": -none, "torque_upper": none}
    robots = (replace(robot, **limits, motors=replace(robot.motors, jerk=jerk * slide)) for robot in cell.robots)
    found = mrts.retime(replace(cell, robots=tuple(robots)), along_x(profile="quintic"), rates=True)
    assert -1e-6 < found.duration / theirs.duration - 1 < SMOOTH

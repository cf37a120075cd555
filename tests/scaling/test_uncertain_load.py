"""The guaranteed, possible and grid ranges of an uncertain load: properties, closed forms, independent programs."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import yaml
from cell_bank import drawn_until, random_planar_cell, random_spatial_cell
from conftest import DATA
from draws import seeds
from reference import ReferenceCell
from scipy.optimize import linprog

import mrts
from mrts.base.load_box import load_vector
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import sample_ranges
from mrts.scaling.range import intersect

UR5 = DATA.parent / "dual_ur5"

RANGE_TOLERANCE = 1e-8  # the bar of a guaranteed end; programs are verified to 1e-9

SEARCH_TOLERANCE = 1e-6  # what the nonlinear program's answer must reach

GRID = 1e-3  # a grid of 2001 loads misses an interior optimum by about this

RULES = 12

scaled = partial(mrts.scale, between=None)  # ranges of the same samples are compared

QUESTIONS = ("guaranteed", "nominal", "possible")


@pytest.fixture(scope="module")
def lift_and_turn():
    return mrts.load_motion(UR5 / "lift_and_turn.yaml")


def random_box(rng, cell):
    """A cell with ranges of some parameters, the nominal values among them."""
    ranges = {}
    for name in ("mass", "ixx", "iyy", "izz"):
        if name == "mass" or rng.random() < 0.5:
            ranges[name] = (float(rng.uniform(0.3, 1)), float(rng.uniform(1, 2)))
    for name in ("mx", "my", "mz"):
        if rng.random() < 0.3:
            ranges[name] = (-0.02 * cell.mass, 0.03 * cell.mass)
    return cell.with_variation(**ranges)


def coordinated(rng, make, arms, folder):
    """A random cell with a random box of loads, and its motion."""
    case = make(rng, folder, arms)
    return random_box(rng, case.cell), mrts.follow_object(case.cell, case.motion)


def at_sample(motion, sample, count):
    """A motion that is one sample of another, many times over, in next to no time."""
    given = motion.object
    fields = (given.position, given.rotation, given.twist, given.acceleration, motion.q, motion.dq, motion.ddq)
    p, R, twist, change, *joints = (np.repeat(field[[sample]], count, axis=0) for field in fields)
    instant = mrts.ObjectMotion(np.linspace(0, 1e-12, count), p, R, twist, change)
    return mrts.CoordinatedMotion(instant, *joints)


def ends_of_loads(cell, motion, sample, loads, sharing=None):
    repeated = at_sample(motion, sample, max(2, len(loads)))
    problem = build_sample_problem(cell, repeated, sharing=sharing, load=np.resize(loads, (len(repeated.q), 10)))
    return sample_ranges(problem, repeated.object.time, "qpsol:qpoases")


@pytest.mark.parametrize("make", [random_planar_cell, random_spatial_cell])
@pytest.mark.parametrize("sharing", [None, mrts.LoadSharing()])
@pytest.mark.parametrize("seed", seeds(1, 2))
def test_guaranteed_lies_in_nominal_lies_in_possible(seed, make, sharing, tmp_path):
    cell, motion = coordinated(np.random.default_rng(seed), make, 1 + seed % 3, tmp_path)
    sure, nominal, some = (scaled(cell, motion, sharing=sharing, load=question).range for question in QUESTIONS)
    for inner, outer in ((sure.samples, nominal.samples), (nominal.samples, some.samples)):
        slack = RANGE_TOLERANCE * (1 + np.where(np.isfinite(inner.upper), np.abs(inner.upper), 0))
        inside = inner.lower <= inner.upper
        assert np.all((outer.lower <= inner.lower + slack)[inside])
        assert np.all((outer.upper >= inner.upper - slack)[inside])
        # an infeasible outer range leaves nothing inside
        assert all(a is not mrts.SampleStatus.INFEASIBLE or b is not mrts.SampleStatus.FEASIBLE
                   for a, b in zip(outer.status, inner.status, strict=True))  # fmt: skip


@pytest.mark.parametrize("make", [random_planar_cell, random_spatial_cell])
@pytest.mark.parametrize("sharing", [None, mrts.LoadSharing()])
def test_many_samples_of_random_cells_have_a_guaranteed_range(make, sharing, tmp_path):
    inside = 0
    for seed in range(6):
        cell, motion = coordinated(np.random.default_rng(seed), make, 1 + seed % 3, tmp_path)
        found = scaled(cell, motion, sharing=sharing, load="guaranteed").range.samples
        inside += np.sum(found.lower <= found.upper)
    assert inside > 12


def guaranteed_with_an_end(pair):
    """The range that every load of a cell's box keeps, if something sets its upper end."""
    found = scaled(*pair, load="guaranteed").range
    return found if found.status.admits_motion and found.upper.sample is not None else None


@pytest.mark.parametrize("make", [random_planar_cell, random_spatial_cell])
@pytest.mark.parametrize("seed", seeds(1, 1))
def test_no_load_of_the_box_violates_the_guaranteed_range_and_a_corner_attains_it(seed, make, tmp_path):
    rng = np.random.default_rng([100 + seed, 2])
    (cell, motion), found = drawn_until(guaranteed_with_an_end, lambda: coordinated(rng, make, 2, tmp_path))
    drawn = [point.load for point in cell.load_box.draw(rng, 1500)]
    grid = [cell.load_box.load_at({"mass": k}).tolist() for k in np.linspace(*cell.load_box.ranges["mass"], 200)]
    samples = ends_of_loads(cell, motion, found.upper.sample, drawn + grid)
    assert np.min(samples.upper) >= found.upper.c2 * (1 - RANGE_TOLERANCE)
    low = ends_of_loads(cell, motion, found.lower.sample, drawn + grid)
    assert np.max(low.lower) <= found.lower.c2 + RANGE_TOLERANCE * (1 + found.lower.c2)
    corner = ends_of_loads(cell, motion, found.upper.sample, [found.upper.load.load])
    assert corner.upper[0] == pytest.approx(found.upper.c2, rel=RANGE_TOLERANCE)


def test_ten_thousand_loads_of_the_reference_cell_keep_the_guaranteed_end(dual_ur5, lift_and_turn):
    cell = dual_ur5.with_variation(mass=(0.3, 2.0), ixx=(0.5, 2), iyy=(0.5, 2), izz=(0.5, 2), mx=(-0.1, 0.1))
    motion = mrts.follow_object(cell, lift_and_turn)
    found = scaled(cell, motion, load="guaranteed").range
    drawn = [point.load for point in cell.load_box.draw(np.random.default_rng(1), 10_000)]
    ends = ends_of_loads(cell, motion, found.upper.sample, [found.upper.load.load, *drawn])
    assert ends.upper[0] == pytest.approx(found.upper.c2, rel=RANGE_TOLERANCE)
    assert np.min(ends.upper) >= found.upper.c2 * (1 - RANGE_TOLERANCE)


def test_the_guaranteed_range_equals_the_reference_over_the_corners(tmp_path):
    description = yaml.safe_load((DATA / "cell.yaml").read_text())
    for robot in description["robots"]:
        robot["urdf"] = str(DATA / "planar_arm.urdf")
    ends = []
    for factor in (0.2, 6.0):
        heavier = description | {"object": {"mass": 0.5 * factor, "inertia": description["object"]["inertia"]}}
        path = tmp_path / f"{factor}.yaml"
        path.write_text(yaml.safe_dump(heavier))
        cell = ReferenceCell(path)
        _, samples = cell.object_motion(DATA / "lift.yaml")
        joints = cell.joint_motion(samples)
        at = [[arm[k] for arm in joints] for k in range(len(samples))]
        ends += [cell.range_at(cell.terms(s, j), j, even=False)[2] for s, j in zip(samples, at, strict=True)]
    ours = mrts.load_cell(DATA / "cell.yaml").with_variation(mass=(0.2, 6.0))
    found = scaled(ours, mrts.load_motion(DATA / "lift.yaml")).range
    assert found.upper.c2 == pytest.approx(min(ends), rel=SEARCH_TOLERANCE)
    assert found.upper.load.load[0] == pytest.approx(3.0)


def on_forks(cell, highest=None):
    """The planar cell with grippers that can lift but not push down: f_y >= 1 N, and at most `highest`."""
    robots = []
    for robot in cell.robots:
        lower, upper = (np.array([end, side, end]) for end, side in ((-np.inf, 1.0), (np.inf, highest or np.inf)))
        robots.append(replace(robot, wrench_lower=lower, wrench_upper=upper))
    return replace(cell, robots=tuple(robots))


def lift_described():
    return yaml.safe_load((DATA / "lift.yaml").read_text())


@pytest.fixture(scope="module")
def lowering():
    given = lift_described()
    given["start"], given["end"] = given["end"], given["start"]
    return mrts.sample_motion(mrts.MotionDescription.model_validate(given))


@pytest.mark.quick
def test_the_worst_load_of_a_lowering_is_the_lightest(planar_cell, lowering):
    """On forks 2 f_y = m (g - c² a) >= 2 N: at the start c² <= (g - 2/m)/a, which the lightest load makes smallest."""
    cell = on_forks(planar_cell).with_variation(mass=(0.6, 1.4))
    found = scaled(cell, lowering).range
    a = -lowering.acceleration[0, 1]
    assert found.upper.load.load[0] == pytest.approx(0.3)
    assert found.upper.c2 == pytest.approx((9.8 - 2 / 0.3) / a, rel=RANGE_TOLERANCE)
    assert {row.name.element for row in found.upper.rows} == {"fy"}


def test_a_load_inside_the_box_can_be_the_best(planar_cell, lift):
    """While the object slows down its weight helps and its inertia hurts: the best mass lies between the ends."""
    cell = planar_cell.with_variation(mass=(0.2, 6.0))
    motion = mrts.follow_object(cell, lift)
    result = scaled(cell, motion, load="possible")
    assert result.load.not_converged == ()
    best = result.range.samples
    of_corners = np.max([found.samples.upper for found in result.load.ranges], axis=0)
    gain = best.upper / of_corners
    sample = int(np.argmax(gain))
    assert gain[sample] > 1.05
    low, high = cell.load_box.ranges["mass"]
    assert low < best.upper_loads[sample].parameters["mass"] < high
    grid = [cell.load_box.load_at({"mass": float(k)}) for k in np.linspace(low, high, 2001)]
    over_grid = np.max(ends_of_loads(cell, motion, sample, grid).upper)
    assert over_grid * (1 - RANGE_TOLERANCE) <= best.upper[sample] <= over_grid * (1 + GRID)


def test_where_the_load_enters_monotonically_the_best_is_a_corner(planar_cell, lift):
    cell = planar_cell.with_variation(mass=(0.2, 6.0))
    result = scaled(cell, lift, load="possible")
    grid = scaled(cell, lift, load="grid:601")
    of_masses = np.array([found.samples.upper for found in grid.load.ranges])
    steps = np.diff(of_masses, axis=0)
    monotone = np.all(steps <= 0, axis=0) | np.all(steps >= 0, axis=0)
    assert 10 < np.sum(monotone) < 101
    assert result.load.not_converged == ()
    best = result.range.samples.upper
    np.testing.assert_allclose(best[monotone], np.max(of_masses, axis=0)[monotone], rtol=SEARCH_TOLERANCE)
    assert np.all(best >= np.max(of_masses[[0, -1]], axis=0) * (1 - RANGE_TOLERANCE))
    assert np.all(best >= np.max(of_masses, axis=0) * (1 - SEARCH_TOLERANCE))
    assert result.trajectory is None


@pytest.mark.parametrize("seed", seeds(3, RULES - 3))
def test_the_guaranteed_range_of_a_fixed_rule_is_that_of_its_corners(seed, tmp_path):
    cell, motion = coordinated(np.random.default_rng(200 + seed), random_planar_cell, 1 + seed % 3, tmp_path)
    rule = mrts.LoadSharing()
    result = scaled(cell, motion, sharing=rule)
    problems = [
        build_sample_problem(cell, motion, sharing=rule, load=corner.load) for corner in cell.load_box.corners()
    ]
    corners = [sample_ranges(problem, motion.object.time, "qpsol:qpoases") for problem in problems]
    found = result.range.samples
    np.testing.assert_allclose(found.lower, np.max([c.lower for c in corners], axis=0), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.upper, np.min([c.upper for c in corners], axis=0), rtol=1e-9)
    end = intersect(found).upper
    if end is not None and end.sample is not None:
        worst = ends_of_loads(cell, motion, end.sample, [end.load.load], rule)
        assert worst.upper[0] == pytest.approx(end.c2, rel=1e-9)


def test_how_fast_a_motion_is_given_hides_no_parameter(dual_ur5, lift_and_turn):
    """c²⁺ is proportional to the square of the duration, whatever that is."""
    cell = dual_ur5.with_variation(izz=(1, 50))
    ends = []
    for factor in (1.0, 1e7):
        slow = mrts.ObjectMotion(
            lift_and_turn.time * factor,
            lift_and_turn.position,
            lift_and_turn.rotation,
            lift_and_turn.twist / factor,
            lift_and_turn.acceleration / factor**2,
        )
        ends.append(scaled(cell, slow).range.upper.c2 / factor**2)
    assert ends[1] == pytest.approx(ends[0], rel=1e-6)


def test_the_search_keeps_its_answer_where_the_best_load_leaves_no_room(planar_cell):
    lift = mrts.sample_motion(mrts.MotionDescription.model_validate(lift_described() | {"samples": 26}))
    cell = planar_cell.with_variation(mass=(0.2, 200.0))
    result = scaled(cell, lift, load="possible", sharing=mrts.LoadSharing())
    assert result.load.not_converged == ()
    grid = scaled(cell, lift, load="grid:2001", sharing=mrts.LoadSharing())
    best = np.max([found.samples.upper for found in grid.load.ranges], axis=0)
    assert np.all(result.range.samples.upper >= best * (1 - SEARCH_TOLERANCE))


@pytest.mark.quick
def test_parameters_without_effect_double_no_work(planar_cell, lift):
    cell = planar_cell.with_variation(mass=(0.2, 6.0), ixx=(0.1, 3), izz=(0.1, 3), mz=(-1, 1))
    result = scaled(cell, lift)
    assert [dict(point.parameters) for point in result.load.points] == [{"mass": 0.2}, {"mass": 6.0}]
    assert result.range.upper.c2 == scaled(planar_cell.with_mass(3.0), lift).range.upper.c2


def test_the_grid_is_bounded_by_the_guaranteed_range(planar_cell, lift):
    cell = planar_cell.with_variation(mass=(0.2, 6.0))
    result = scaled(cell, lift, load="grid:7")
    assert [point.parameters["mass"] for point in result.load.points] == pytest.approx(np.linspace(0.2, 6, 7))
    assert result.range.upper.c2 == pytest.approx(scaled(cell, lift).range.upper.c2, rel=RANGE_TOLERANCE)
    for point, found in zip(result.load.points, result.load.ranges, strict=True):
        alone = scaled(planar_cell.with_mass(point.load[0]), lift).range
        assert found.upper.c2 == pytest.approx(alone.upper.c2, rel=RANGE_TOLERANCE)


def test_first_moments_equal_an_object_whose_frame_lies_elsewhere(dual_ur5, lift_and_turn, tmp_path):
    """A load with its com at d is the same body as one seen from its com, with grasps and path moved by d."""
    d, mass = np.array([0.03, -0.02, 0.05]), dual_ur5.mass
    about_origin = dual_ur5.inertia + mass * (d @ d * np.eye(3) - np.outer(d, d))
    here = scaled(dual_ur5.with_load(load_vector(mass, mass * d, about_origin)), lift_and_turn)
    given = lift_and_turn
    v, w, a, dw = given.twist[:, :3], given.twist[:, 3:], given.acceleration[:, :3], given.acceleration[:, 3:]
    r = given.rotation @ d
    centre = mrts.ObjectMotion(
        given.time,
        given.position + r,
        given.rotation,
        np.hstack([v + np.cross(w, r), w]),
        np.hstack([a + np.cross(dw, r) + np.cross(w, np.cross(w, r)), dw]),
    )
    description = yaml.safe_load((UR5 / "cell.yaml").read_text())
    for robot in description["robots"]:
        robot["urdf"] = str(UR5 / robot["urdf"])
        robot["grasp"]["xyz"] = (np.array(robot["grasp"]["xyz"]) - d).tolist()
    (tmp_path / "cell.yaml").write_text(yaml.safe_dump(description))
    there = scaled(mrts.load_cell(tmp_path / "cell.yaml"), centre)
    np.testing.assert_allclose(here.range.samples.upper, there.range.samples.upper, rtol=1e-7)
    np.testing.assert_allclose(here.range.samples.lower, there.range.samples.lower, atol=1e-7)


def test_an_outer_hull_holds_every_load_with_its_com_in_the_range(dual_ur5, lift_and_turn):
    cell = dual_ur5.with_variation(mass=(0.5, 2), com_x=(-0.1, 0.05), com_y=(0, 0.08), izz=(0.5, 2), outer_hull=True)
    corners = np.array([corner.load for corner in cell.load_box.corners()])
    assert len(corners) == 2 * 2 * 3 * 3
    scale = np.maximum(np.max(np.abs(corners), axis=0), 1e-12)
    drawn = cell.load_box.draw(np.random.default_rng(3), 200)
    for point in drawn:
        A = np.vstack([(corners / scale).T, np.ones(len(corners))])
        inside = linprog(np.zeros(len(corners)), A_eq=A, b_eq=[*(point.load / scale), 1])
        assert inside.status == 0, point
        m, c = point.load[0], np.array([point.parameters["com_x"], point.parameters["com_y"], 0])
        np.testing.assert_allclose(point.load[1:4], m * c, atol=1e-14)
    motion = mrts.follow_object(cell, lift_and_turn)
    found = scaled(cell, motion).range
    ends = ends_of_loads(cell, motion, found.upper.sample, [point.load for point in drawn])
    assert np.min(ends.upper) >= found.upper.c2 * (1 - RANGE_TOLERANCE)
    with pytest.raises(mrts.InputError, match="loads that do not exist"):
        scaled(cell, motion, load="possible")


def test_a_known_load_of_the_box_has_torques_at_the_guaranteed_c2(dual_ur5, lift_and_turn):
    cell = dual_ur5.with_variation(mass=(0.3, 2.0), ixx=(0.5, 2), izz=(0.5, 2), my=(-0.1, 0.1))
    result = scaled(cell, lift_and_turn)
    for point in (*cell.load_box.draw(np.random.default_rng(4), 10), *cell.load_box.corners()):
        carried = mrts.torques_for_load(result, point.load)
        assert carried.trajectory.c2 == result.trajectory.c2
        checks = carried.residuals()
        assert checks.limits <= RANGE_TOLERANCE
        assert max(checks.arms, checks.object) <= 1e-9 * (1 + np.max(np.abs(carried.trajectory.wrench)))
    even = scaled(cell.without_velocity_limits(), lift_and_turn, 5.0, sharing=mrts.LoadSharing())
    again = mrts.torques_for_load(even, cell.load)
    np.testing.assert_allclose(again.trajectory.torque, even.trajectory.torque, atol=1e-9)  # the result's own rule
    with pytest.raises(mrts.SelectionError, match="does not suit this load") as refused:
        mrts.torques_for_load(result, cell.load * 5)
    assert refused.value.result.range.upper.c2 < result.trajectory.c2


def test_a_load_that_cannot_be_carried_is_named(planar_cell, lift):
    result = scaled(planar_cell.with_variation(mass=(0.2, 200.0)), lift)
    assert result.status is mrts.ScalingStatus.INFEASIBLE
    assert "the object with mass 100 kg" in result.summary()
    assert result.range.samples.conflicts[0].load.load[0] == 100
    for rule in (None, mrts.LoadSharing()):
        assert scaled(planar_cell.with_variation(mass=(0.2, 200.0)), lift, sharing=rule).status.value == "infeasible"
    some = scaled(planar_cell.with_variation(mass=(0.2, 200.0)), lift, load="possible")
    assert some.status is mrts.ScalingStatus.FEASIBLE


@pytest.mark.quick
def test_loads_that_share_no_speed_are_told_apart(planar_cell, lowering):
    """With 1 N <= f_y <= 3 N a light load sets an upper and a heavy one a lower end at t = 0."""
    cell = on_forks(planar_cell, 3.0).with_variation(mass=(0.45, 2.0))
    first = slice(20)  # before the braking, which the heavy load cannot survive at all
    fields = (lowering.time, lowering.position, lowering.rotation, lowering.twist, lowering.acceleration)
    result = scaled(cell, mrts.ObjectMotion(*(field[first] for field in fields)))
    assert result.status is mrts.ScalingStatus.EMPTY
    assert result.range.samples.status[0] is mrts.SampleStatus.EMPTY
    assert "mass 1 kg" in result.summary()
    assert "mass 0.225 kg" in result.summary()
    a = -lowering.acceleration[0, 1]
    assert result.range.samples.lower[0] == pytest.approx((9.8 - 6 / 1.0) / a, rel=RANGE_TOLERANCE)
    assert result.range.samples.upper[0] == pytest.approx((9.8 - 2 / 0.225) / a, rel=RANGE_TOLERANCE)

"""Ranges of an uncertain load: properties, closed forms, independent programs; questions that are refused."""

import json
from functools import partial

import numpy as np
import pytest
from cell_bank import drawn_until, random_planar_cell, random_spatial_cell
from changed_robots import with_robots
from conftest import DATA
from draws import seeds
from shipped_cells import cell_file, changed_cell, shipped, shipped_motion

import mrts
from mrts.base.load_box import load_vector
from mrts.cli import main
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import SampleStatus, sample_ranges

RANGE_TOLERANCE = 1e-8  # the bar of a guaranteed end; programs are verified to 1e-9

GRID = 1e-3  # a grid of 2001 loads misses an interior optimum by about this

scaled = partial(mrts.scale, between=None)  # ranges of the same samples are compared


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
    problem = build_sample_problem(
        motion_rows(cell, repeated, sharing, solver="qpsol:qpoases"), load=np.resize(loads, (len(repeated.q), 10))
    )
    return sample_ranges(problem, repeated.object.time)


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


def on_forks(cell, highest=None):
    """The planar cell with grippers that can lift but not push down: f_y >= 1 N, and at most `highest`."""
    lower, upper = (np.array([end, side, end]) for end, side in ((-np.inf, 1.0), (np.inf, highest or np.inf)))
    return with_robots(cell, wrench_lower=lower, wrench_upper=upper)


@pytest.fixture(scope="module")
def lowering():
    given = shipped_motion()
    return mrts.load_motion(given | {"start": given["end"], "end": given["start"]})


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
    assert low < best.loads[1][sample].parameters["mass"] < high
    grid = [cell.load_box.load_at({"mass": float(k)}) for k in np.linspace(low, high, 2001)]
    over_grid = np.max(ends_of_loads(cell, motion, sample, grid).upper)
    assert over_grid * (1 - RANGE_TOLERANCE) <= best.upper[sample] <= over_grid * (1 + GRID)


@pytest.mark.quick
def test_parameters_without_effect_double_no_work(planar_cell, lift):
    cell = planar_cell.with_variation(mass=(0.2, 6.0), ixx=(0.1, 3), izz=(0.1, 3), mz=(-1, 1))
    result = scaled(cell, lift)
    assert [dict(point.parameters) for point in result.load.points] == [{"mass": 0.2}, {"mass": 6.0}]
    assert result.range.upper.c2 == scaled(planar_cell.with_mass(3.0), lift).range.upper.c2


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
    description = shipped("dual_ur5")
    for robot in description["robots"]:
        robot["grasp"]["xyz"] = (np.array(robot["grasp"]["xyz"]) - d).tolist()
    there = scaled(mrts.load_cell(cell_file(tmp_path, description)), centre)
    np.testing.assert_allclose(here.range.samples.upper, there.range.samples.upper, rtol=1e-7)
    np.testing.assert_allclose(here.range.samples.lower, there.range.samples.lower, atol=1e-7)


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
    with pytest.raises(mrts.SelectionError, match=r"does not suit this load: c² ∈ \[0, .* upper end is set") as refused:
        mrts.torques_for_load(result, cell.load * 5)
    assert refused.value.result.range.upper.c2 < result.trajectory.c2


@pytest.mark.quick
def test_loads_that_share_no_speed_are_told_apart(planar_cell, lowering):
    """With 1 N <= f_y <= 3 N a light load sets an upper and a heavy one a lower end at t = 0."""
    cell = on_forks(planar_cell, 3.0).with_variation(mass=(0.45, 2.0))
    fields = (lowering.time, lowering.position, lowering.rotation, lowering.twist, lowering.acceleration)
    start = mrts.ObjectMotion(*(field[:20] for field in fields))  # a heavy load cannot survive the braking at all
    result = scaled(cell, start)
    assert result.status is mrts.ScalingStatus.EMPTY
    assert result.range.samples.status[0] is SampleStatus.EMPTY
    assert "mass 1 kg" in result.summary()
    assert "mass 0.225 kg" in result.summary()
    a = -lowering.acceleration[0, 1]
    assert result.range.samples.lower[0] == pytest.approx((9.8 - 6 / 1.0) / a, rel=RANGE_TOLERANCE)
    assert result.range.samples.upper[0] == pytest.approx((9.8 - 2 / 0.225) / a, rel=RANGE_TOLERANCE)


def test_the_command_line_asks_what_the_cell_file_says(tmp_path, capsys):
    inertia = [[0.02, 0.004, 0], [0.004, 0.2, 0], [0, 0, 0.2]]
    uncertain = {"variation": {"mass": [0.2, 6.0], "izz": [0.5, 2.0]}, "inertia": inertia}
    path = changed_cell(tmp_path, lambda cell: cell["object"].update(uncertain))
    command = ["scale", str(path), str(DATA / "lift.yaml")]
    assert main([*command, "--json", str(tmp_path / "out.json")]) == 0
    said = capsys.readouterr().out
    assert "for every load of the box (mass 0.1 … 3 kg" in said
    result = json.loads((tmp_path / "out.json").read_text())
    assert result["load"]["question"] == "guaranteed"
    assert result["binding"]["upper"]["load"]["parameters"] == {"mass": 6.0}
    assert [point["c2"]["upper"] for point in result["load"]["points"]] == pytest.approx([3.352, 1.516], abs=1e-3)
    box = mrts.load_cell(tmp_path / "cell.yaml").load_box
    with pytest.raises(mrts.InputError, check=lambda error: (error.key, error.value) == ("mass", 7.0)):
        box.load_at({"mass": 7.0})
    assert main([*command, "--load", "possible"]) == 0

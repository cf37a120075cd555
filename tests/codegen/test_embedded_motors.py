"""Motors in exported libraries: as on the desktop; joints that turn back."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from draws import seeds
from loaded_library import PLACES, LoadedLibrary, reals, structure
from shipped_cells import changed_cell

import mrts
from mrts.cell.robot import JointMotors
from mrts.cli import main
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import motion_ranges
from mrts.program.torque_distribution import distribute_torques, torque_weights

OK, INFEASIBLE, EMPTY, BAD_ARGUMENT = 0, 2, 3, 5
FREE, EVEN = "range_of_sample", "equal_share_range"

SAME_TORQUE = 1e-9
"""Of a torque by the library and by Python, as a share of its limit."""

SAME_C2 = 1e-7
"""Of ends of c²: where inertia balances friction it moves far for the rounding of a limit."""

CURVES = [[[0, 100], [1.5, 100], [4, 30]], [[0, 80], [2, 80], [5, 10]], [[0, 50], [6, 20]]]


def with_curves(cell):
    """Curves, and the friction of which settings at run time take the place."""
    friction = {"coulomb": [6, 5, 2], "viscous": [8, 8, 3]}
    for robot in cell["robots"]:
        robot["motors"] = {"armature": [0.5, 0.4, 0.1], "friction": friction, "torque_speed": CURVES}


def with_a_gap(cell):
    """Friction hinders in the middle of the speeds that inertia helps to."""
    for robot in cell["robots"]:
        robot["motors"] = {"friction": {"viscous": [37, 15, 0]}}
        robot["torque"] = [31, 79, 71]


def loaded(folder, change):
    """The library of the planar cell after a change, the cell, and its lift."""
    path = changed_cell(folder, change)
    assert main(["export", str(path), "-o", str(folder / "library"), "--motion", str(DATA / "lift.yaml")]) == 0
    cell = mrts.load_cell(path)
    motion = mrts.follow_object(cell, mrts.load_motion(DATA / "lift.yaml"))
    return LoadedLibrary(folder / "library", folder), cell, motion


@pytest.fixture(scope="module")
def curved_once(tmp_path_factory):
    return loaded(tmp_path_factory.mktemp("curved"), with_curves)


@pytest.fixture
def curved(curved_once):
    curved_once[0].call("default_settings", curved_once[0].settings)
    return curved_once


@pytest.fixture(scope="module")
def gapped(tmp_path_factory):
    return loaded(tmp_path_factory.mktemp("gapped"), with_a_gap)


@pytest.mark.parametrize("seed", seeds(4, 4))
def test_ranges_of_random_motors_are_those_of_the_desktop(curved, seed):
    library, cell, motion = curved
    rng = np.random.default_rng(seed)
    limit = np.array([100.0, 80.0, 50.0])
    motors = [
        JointMotors(
            **{name: getattr(robot.motors, name) for name in ("torque_speed", "torque_rate", "jerk", "rated", "power")},
            armature=rng.uniform(0, 0.01, 3) * limit * rng.choice([0, 1, 3], 3),
            coulomb=rng.uniform(0, 0.15, 3) * limit * rng.choice([0, 1], 3),
            viscous=rng.uniform(0, 0.5, 3) * limit * rng.choice([0, 1, 2], 3),
        )
        for robot in cell.robots
    ]
    for name in ("armature", "coulomb", "viscous"):
        getattr(library.settings, name)[:] = np.concatenate([getattr(motor, name) for motor in motors]).tolist()
    robots = tuple(replace(robot, motors=motor) for robot, motor in zip(cell.robots, motors, strict=True))
    changed = replace(cell, robots=robots)
    index = np.array([rng.integers(motion.samples)])
    sample = library.sample(motion, int(index[0]))
    for call, sharing in ((FREE, None), (EVEN, mrts.LoadSharing())):
        wanted = motion_ranges(motion_rows(changed, motion, sharing))
        status, found, rows = library.range(sample, call)
        low, high = wanted.lower[index[0]], wanted.upper[index[0]]
        assert (status == INFEASIBLE) == (not found.size) == (low > high)
        if found.size:
            np.testing.assert_allclose(found, [[low, high]], rtol=SAME_C2, atol=SAME_C2)
            assert all(rows[0])
    _, found, _ = library.range(sample)
    if found.size:
        c2 = float(found[-1].mean())
        problem = build_sample_problem(motion_rows(changed, motion), samples=index)
        x = distribute_torques(problem, c2, torque_weights(None, cell))
        status, torque, wrench = library.torques(sample, c2)
        assert status == OK
        assert np.abs(torque - problem.torque(x)[0]).max() <= SAME_TORQUE * limit.min()
        assert np.abs(wrench - problem.wrench(x)[0]).max() <= SAME_TORQUE * limit.max()


def test_a_guaranteed_range_goes_down_to_slower_intervals(gapped):
    library, _, motion = gapped
    nominal, both, apart = list(library.settings.load), library.Range(), 0
    for index, factor in ((index, factor) for index in range(55, 80) for factor in (0.5, 0.7, 1.2, 1.5, 2.0)):
        sample, loads, ranges = library.sample(motion, index), (type(library.settings.load) * 2)(), []
        for load, mass in zip(loads, (nominal[0], factor * nominal[0]), strict=True):
            load[:] = library.settings.load[:] = [mass, *nominal[1:]]
            ranges.append(library.range(sample)[1])
        library.settings.load[:] = nominal
        if not all(found.size for found in ranges):
            continue
        lower, upper = np.array(ranges)[:, 0].T
        status = library.call(
            "guaranteed_range", sample, library.settings, loads, 2, both, None, None, library.workspace
        )
        if lower.max() <= upper.min():
            assert (both.lower, both.upper) == pytest.approx((lower.max(), upper.min()), rel=SAME_TORQUE)
        elif status == OK:
            apart += 1
            assert both.upper <= upper.min()
            for load in loads:
                library.settings.load[:] = list(load)
                assert library.torques(sample, both.upper)[0] == OK
            library.settings.load[:] = nominal
    assert apart


def terms_of(library, sample):
    """Terms of a sample by name."""
    joints, part, wrenches = (library.sizes[name] for name in ("JOINTS", "WRENCH", "WRENCHES"))
    sizes = {"E": joints, "A": joints, "G": joints, "J": part * joints, "B": part * wrenches}
    found = structure(reals(sizes | dict.fromkeys("PSQ", part) | dict.fromkeys(("V", "C", "turning"), joints)))()
    library.call("terms", sample, library.settings, found)
    return {name: np.array(getattr(found, name)) for name, _ in found._fields_}


def test_friction_of_a_joint_that_stands_is_against_its_travel(curved):
    library, _, motion = curved
    sample, coulomb = library.sample(motion, 40), np.array(library.settings.coulomb)
    ddq = np.where(np.arange(6) % 2, 1.0, -1.0)
    sample.dq[:], sample.ddq[:] = [0.0] * 6, ddq.tolist()
    wanted = {"inside": 0 * coulomb, "start": coulomb * ddq, "end": -coulomb * ddq}
    for place, number in PLACES.items():
        sample.place = number
        found = terms_of(library, sample)
        assert np.array_equal(found["C"], wanted[place])
        assert np.array_equal(found["turning"], coulomb if place == "inside" else 0 * coulomb)
    sample.place = PLACES["inside"]
    for call in (FREE, EVEN):
        _, turning, _ = library.range(sample, call)
        narrowed(library, coulomb)
        _, wanted_range, _ = library.range(sample, call)
        library.call("default_settings", library.settings)
        assert turning.size
        assert np.allclose(turning, wanted_range, rtol=SAME_TORQUE, atol=0)
        one_way = []
        for place in ("start", "end"):
            sample.place = PLACES[place]
            one_way.append(library.range(sample, call)[1][0, 1])
        assert turning[0, 1] <= min(one_way) * (1 + SAME_TORQUE) < max(one_way)
        sample.place = PLACES["inside"]


def narrowed(library, coulomb):
    """No dry friction, and limits of torques that leave room for it in both directions."""
    settings, joint_of_line = library.settings, [j + 3 * arm for arm in (0, 1) for j in (0, 1, 2)]
    lines = library.sizes["ROWS"] - library.sizes["LINES"]
    settings.coulomb[:] = [0.0] * 6
    for row in (*range(6), *range(lines, library.sizes["ROWS"])):
        room = coulomb[row if row < lines else joint_of_line[row - lines]]
        settings.lower[row] += room
        settings.upper[row] -= room


@pytest.mark.parametrize("name", ["armature", "coulomb", "viscous", "slope", "rest"])
def test_motors_that_are_none_are_refused(curved, name):
    library, _, motion = curved
    sample, settings = library.sample(motion, 40), library.settings
    assert library.call("check_settings", settings) == OK
    for wrong in (-1.0, np.nan, np.inf):
        if name == "rest" and wrong == np.inf:
            continue
        getattr(settings, name)[1] = wrong
        assert library.call("check_settings", settings) == BAD_ARGUMENT
        if name != "rest" and wrong != -1.0:
            assert [library.range(sample, call)[0] for call in (FREE, EVEN)] == [BAD_ARGUMENT] * 2
            assert library.torques(sample, 1.0)[0] == BAD_ARGUMENT
        library.call("default_settings", settings)
    for place in (-1, 3):
        sample.place = place
        assert library.range(sample)[0] == library.torques(sample, 1.0)[0] == BAD_ARGUMENT

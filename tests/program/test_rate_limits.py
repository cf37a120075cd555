"""`contact_rate` of the cell file, and the rates that a cell is to keep: where they are from and what is refused."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
import yaml
from conftest import DATA

import mrts
from mrts.cell.motors import JointMotors
from mrts.cli import main
from mrts.program.rate_limits import given_rate_limits, rate_limits

pytestmark = pytest.mark.quick

FRANKA = 1000 / 87
"""[1/s], https://frankarobotics.github.io/docs/control_parameters.html"""


def cell_file(folder, **keys):
    """The shipped planar cell with more keys of its left robot."""
    for path in DATA.iterdir():
        shutil.copy(path, folder / path.name)
    data = yaml.safe_load((folder / "cell.yaml").read_text())
    data["robots"][0] |= keys
    (folder / "cell.yaml").write_text(yaml.safe_dump(data))
    return folder / "cell.yaml"


def test_the_cell_file_gives_contact_rates_and_the_manifest_keeps_them(tmp_path):
    path = cell_file(tmp_path, contact_rate=[500, 40.5])
    cell = mrts.load_cell(path)
    np.testing.assert_array_equal(cell.robots[0].contact_rate, [500, 500, 40.5])
    np.testing.assert_array_equal(cell.robots[1].contact_rate, [np.inf] * 3)
    assert main(["generate", str(path), "-o", str(tmp_path / "generated")]) == 0
    again = mrts.load_cell(tmp_path / "generated")
    np.testing.assert_array_equal(again.robots[0].contact_rate, [500, 500, 40.5])
    manifest = json.loads((tmp_path / "generated" / "manifest.json").read_text())
    assert manifest["cell"]["robots"][1]["contact_rate"] == ["inf"] * 3


def test_forces_alone_or_moments_alone_may_be_limited(tmp_path):
    cell = mrts.load_cell(cell_file(tmp_path, contact_rate=[None, 3]))
    np.testing.assert_array_equal(cell.robots[0].contact_rate, [np.inf, np.inf, 3])


def test_a_saved_result_has_them(tmp_path, planar_cell, lift):
    left, right = planar_cell.robots
    cell = replace(planar_cell, robots=(replace(left, contact_rate=np.array([5e3, 6e3, np.inf])), right))
    mrts.save_result(mrts.scale(cell, lift), tmp_path / "result.npz")
    again = mrts.load_result(tmp_path / "result.npz").cell.robots
    np.testing.assert_array_equal(again[0].contact_rate, [5e3, 6e3, np.inf])
    np.testing.assert_array_equal(again[1].contact_rate, [np.inf] * 3)
    np.testing.assert_array_equal(cell.without_wrench_limits().robots[0].contact_rate, [np.inf] * 3)


@pytest.mark.parametrize(
    ("rate", "parts"),
    [
        ([500, 0], ["robots[0].contact_rate[1]", "= 0"]),
        ([-1, 50], ["robots[0].contact_rate[0]", "-1"]),
        ([500], ["robots[0].contact_rate", "[500]", "2"]),
        ([500] * 6, ["robots[0].contact_rate", "2"]),
        (500, ["robots[0].contact_rate", "500"]),
        ([500, float("nan")], ["robots[0].contact_rate[1]", "nan"]),
        ([500, float("inf")], ["robots[0].contact_rate[1]", "inf"]),
        (["fast", 50], ["robots[0].contact_rate[0]", "fast"]),
    ],
)
def test_a_wrong_contact_rate_is_refused_by_key(tmp_path, rate, parts):
    path = cell_file(tmp_path, contact_rate=rate)
    with pytest.raises(mrts.InputError) as caught:
        mrts.load_cell(path)
    for part in (path.name, *parts):
        assert part in str(caught.value)


@pytest.mark.parametrize("rate", [[0.0, 1.0, 1.0], [-1.0, 1, 1], [1.0, 1.0], [np.nan, 1, 1], "fast", np.ones(6)])
def test_a_wrong_contact_rate_in_python_is_refused(planar_cell, rate):
    with pytest.raises(mrts.InputError, match="robot 'left': contact_rate = "):
        replace(planar_cell.robots[0], contact_rate=rate)


def with_rates(cell, **changes):
    """The cell with other motors of its left robot, and contact rates of its right one."""
    left, right = cell.robots
    motors = JointMotors.unknown(3)
    changed = replace(left, motors=replace(motors, **{key: np.array(value) for key, value in changes.items()}))
    return replace(cell, robots=(changed, replace(right, contact_rate=np.array([70.0, 70.0, 8.0]))))


def test_true_takes_what_the_cell_gives(planar_cell):
    cell = with_rates(planar_cell, torque_rate=[100, np.inf, 300.0], jerk=[np.inf, 50.0, np.inf])
    found = rate_limits(cell, rates=True)
    np.testing.assert_array_equal(found.torque, [100, np.inf, 300] + [np.inf] * 3)
    np.testing.assert_array_equal(found.wrench, [np.inf] * 3 + [70, 70, 8])
    np.testing.assert_array_equal(found.jerk, [np.inf, 50] + [np.inf] * 4)
    kept = rate_limits(cell.with_reserve(0.1), rates=True)
    np.testing.assert_allclose(kept.torque, 0.9 * found.torque, rtol=1e-15)
    np.testing.assert_allclose(kept.wrench, 0.9 * found.wrench, rtol=1e-15)
    np.testing.assert_allclose(kept.jerk, 0.9 * found.jerk, rtol=1e-15)


def test_a_number_fills_in_torque_rates_by_the_larger_side_of_the_limits(planar_cell):
    cell = with_rates(planar_cell, torque_rate=[100, np.inf, np.inf], jerk=[np.inf, 50.0, np.inf])
    left, right = cell.robots
    cell = replace(cell, robots=(replace(left, torque_lower=np.array([-9.0, -10, 0]), torque_upper=[9, 20, 4]), right))
    found = rate_limits(cell, FRANKA)
    np.testing.assert_allclose(found.torque[:3], [100, FRANKA * 20, FRANKA * 4], rtol=1e-15)
    np.testing.assert_allclose(found.torque[3:], FRANKA * right.torque_upper, rtol=1e-15)
    np.testing.assert_array_equal(found.jerk, given_rate_limits(cell).jerk)
    np.testing.assert_array_equal(found.wrench, given_rate_limits(cell).wrench)


def test_a_cell_without_rates_says_what_to_write(planar_cell):
    assert not given_rate_limits(planar_cell).limits_something
    with pytest.raises(mrts.InputError, match=r"rates = True: .*limits no rate.*torque_rate.*jerk.*contact_rate"):
        rate_limits(planar_cell, rates=True)


@pytest.mark.parametrize("rates", [False, 0, -1, np.nan, np.inf, 1e13, 10**400, "fast", None, [11.5], np.array([1.0])])
def test_what_is_no_rate_is_refused(planar_cell, rates):
    with pytest.raises(mrts.InputError, match=r"^rates.*: must be True, or a number > 0"):
        rate_limits(planar_cell, rates)


def test_a_multiple_of_no_limit_is_refused(planar_cell):
    left, right = planar_cell.robots
    free = replace(left, torque_upper=[np.inf, 1, 1], torque_lower=[-1.0, -1, -1])
    with pytest.raises(mrts.InputError, match=r"rates = 11\.5: .*'shoulder' of robot 'left'.*torque_rate"):
        rate_limits(replace(planar_cell, robots=(free, right)), 11.5)
    motors = replace(JointMotors.unknown(3), torque_rate=np.array([7.0, np.inf, np.inf]))
    known = rate_limits(replace(planar_cell, robots=(replace(free, motors=motors), right)), 11.5)
    np.testing.assert_allclose(known.torque[:3], [7, 11.5, 11.5], rtol=1e-15)

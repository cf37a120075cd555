"""`contact_rate` of the cell file, and the rates that a cell is to keep: where they are from and what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest
from changed_robots import with_left
from shipped_cells import changed_cell

import mrts
from mrts.cell.robot import JointMotors
from mrts.cli import main
from mrts.program.rate_limits import given_rate_limits, rate_limits
from mrts.scaling.constant_rates import RATE_MARGIN

pytestmark = pytest.mark.quick

FRANKA = 1000 / 87
"""[1/s], https://frankarobotics.github.io/docs/control_parameters.html"""


def test_the_cell_file_gives_contact_rates_and_the_manifest_keeps_them(tmp_path):
    path = changed_cell(tmp_path, lambda cell: cell["robots"][0].update(contact_rate=[500, 40.5]))
    cell = mrts.load_cell(path)
    np.testing.assert_array_equal(cell.robots[0].contact_rate, [500, 500, 40.5])
    np.testing.assert_array_equal(cell.robots[1].contact_rate, [np.inf] * 3)
    assert main(["generate", str(path), "-o", str(tmp_path / "generated")]) == 0
    again = mrts.load_cell(tmp_path / "generated")
    np.testing.assert_array_equal(again.robots[0].contact_rate, [500, 500, 40.5])
    manifest = json.loads((tmp_path / "generated" / "manifest.json").read_text())
    assert manifest["cell"]["robots"][1]["contact_rate"] == ["inf"] * 3


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
    cell = with_left(cell, torque_lower=[-9.0, -10, 0], torque_upper=[9, 20, 4])
    found = rate_limits(cell, FRANKA)
    np.testing.assert_allclose(found.torque[:3], [100, FRANKA * 20, FRANKA * 4], rtol=1e-15)
    np.testing.assert_allclose(found.torque[3:], FRANKA * cell.robots[1].torque_upper, rtol=1e-15)
    np.testing.assert_array_equal(found.jerk, given_rate_limits(cell).jerk)
    np.testing.assert_array_equal(found.wrench, given_rate_limits(cell).wrench)


def with_all_rates(cell):
    """Torque rates, jerks and contact rates of one robot that its fastest factor passes."""
    motors = replace(cell.robots[0].motors, torque_rate=np.array([250.0, np.inf, 200.0]), jerk=np.full(3, 450.0))
    return with_left(cell, motors=motors, contact_rate=np.array([30.0, 30.0, np.inf]))


def test_rates_are_reported_and_bind_nothing_unless_they_are_kept(planar_cell, lift, lifted):
    reported = mrts.scale(with_all_rates(planar_cell), lift)
    assert reported.trajectory.c2 == lifted.trajectory.c2
    uses = {(use.name.kind, use.name.element): use for use in reported.rate_uses if use.name.robot == "left"}
    done, duty = reported.trajectory, reported.trajectory.duty["left"]
    rates = np.abs(np.diff(done.torque[:, 0])) / np.diff(done.time)
    shoulder = uses["torque rate", "shoulder"]
    assert (max(-shoulder.least, shoulder.largest), shoulder.time) == (np.max(rates), done.time[np.argmax(rates)])
    assert len(uses) == 2 + 3 + 2
    for kind, values in (("torque rate", duty.torque_rate_share), ("jerk", duty.jerk_share)):
        found = [uses[kind, joint].share for joint in ("shoulder", "elbow", "wrist") if (kind, joint) in uses]
        np.testing.assert_allclose(found, [share for share in values if share > 0], rtol=1e-12)
    worst = max(uses.values(), key=lambda use: use.share)
    (warning,) = (one for one in reported.warnings if one.code == "rate-passed")
    assert f"{worst.name} reaches {max(-worst.least, worst.largest):.4g} {worst.name.unit}" in warning.text
    kept = mrts.scale(with_all_rates(planar_cell), lift, rates=True)
    assert kept.trajectory.c2 < done.c2
    assert kept.rate_uses[0].share == pytest.approx(1, abs=2 * RATE_MARGIN)
    assert [one.code for one in kept.warnings] == ["step-at-ends"]
    listed = {row[0] for row in kept.limits_table().rows}
    assert listed >= {str(use.name) for use in kept.rate_uses}

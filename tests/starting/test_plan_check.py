"""`mrts.check_plan`: sound plans pass, and each kind of damage is found where it is."""

import json
from dataclasses import replace

import numpy as np
import pytest
from command_line import mrts_command
from conftest import UR5
from gantries import along_x, gantries, uphill_gantries
from motion_tables import write_table
from shipped_cells import cell_file, shipped

import mrts
from mrts.base.errors import InputError
from mrts.output.trajectory_table import trajectory_columns

SAME = 1e-6
"""Share of a limit: the sides of a range to which plans are sampled, and programs, are exact to 1e-9."""

BETWEEN = 5e-3
"""Share of a limit by which what is between the rows may differ: places there are three a step."""

NANOSECOND = 1e-5
"""Share of a limit that is lost where times are rounded to whole nanoseconds."""

PARTS = ("q", "dq", "ddq", "tau", "F")


def table(path, columns, kept=PARTS):
    """Write some columns, by name, to a file."""
    chosen = {name: values for name, values in columns.items() if name == "t" or name.partition(".")[0] in kept}
    return write_table(path, chosen, ".17g")


@pytest.fixture
def plan(turned):
    return trajectory_columns(turned)


def share(found, kind, element=None):
    """The largest share of a kind of limit, or of one of its elements ("robot/joint")."""
    own = [use for use in found.uses if use.name.kind == kind]
    return max(use.share for use in own if element in {None, f"{use.name.robot}/{use.name.element}"})


@pytest.mark.quick
def test_a_plan_of_mrts_is_fine_and_uses_its_limits_as_the_result_says(turned, dual_ur5, plan, tmp_path):
    found = mrts.check_plan(dual_ur5, table(tmp_path / "plan.csv", plan))
    assert (found.status, found.given, found.contradictions) == ("fine", PARTS, ())
    ours = {use.name: use for use in found.uses}
    for use in turned.trajectory.limit_uses:
        assert ours[use.name].share >= use.share - SAME
        assert ours[use.name].share <= use.share + BETWEEN
    assert share(found, "torque residual") < SAME
    assert share(found, "balance residual") < SAME
    assert share(found, "grasp distance") < SAME
    assert share(found, "end velocity") == 0


def test_dry_friction_changes_no_rate_from_the_first_row_to_the_next(lift, tmp_path):
    """A smooth plan starts and ends without acceleration: where a joint goes then, the next row tells."""
    motors = {"friction": {"coulomb": 2.0}, "torque_rate": 400.0}
    cell = mrts.load_cell(cell_file(tmp_path, shipped(motors=motors)))
    smooth = mrts.retime(cell, lift, rates=True)
    found = mrts.check_plan(cell, table(tmp_path / "plan.csv", trajectory_columns(smooth.retimed)))
    assert share(found, "torque rate") == pytest.approx(1, abs=BETWEEN)


def test_without_torques_the_share_is_the_least_that_any_have(turned, dual_ur5, plan, tmp_path):
    found = mrts.check_plan(dual_ur5, table(tmp_path / "plan.csv", plan, PARTS[:3]))
    best = 1 - turned.reserve.distributed.share
    assert (found.status, found.given) == ("fine", ("q", "dq", "ddq"))
    assert share(found, "torque") == pytest.approx(best, abs=BETWEEN)
    assert share(found, "wrench") == pytest.approx(best, abs=BETWEEN)


def test_positions_alone_are_played_on_a_cubic_spline(turned, dual_ur5, plan, tmp_path):
    faster = plan | {"t": plan["t"] / 1.3}
    slow, fast = (mrts.check_plan(dual_ur5, table(tmp_path / "plan.csv", given, ("q",))) for given in (plan, faster))
    assert slow.status == "fine"
    assert [use.name.kind for use in fast.passed] == ["velocity"]
    assert fast.passed[0].share == pytest.approx(1.3 * share(slow, "velocity"), rel=SAME)
    limit, _ = max((use.share, use) for use in turned.trajectory.limit_uses if use.name.kind == "velocity")
    assert fast.passed[0].share == pytest.approx(1.3 * limit, abs=BETWEEN)


@pytest.mark.parametrize("merged", [False, True])
def test_bags_are_read_alike(merged, turned, dual_ur5, plan, tmp_path):
    mrts.write_ros_bag(turned, tmp_path / "bag", merged=merged)
    table_, bag = (mrts.check_plan(dual_ur5, path) for path in (table(tmp_path / "plan.csv", plan), tmp_path / "bag"))
    assert (bag.status, bag.given) == ("fine", PARTS)
    shares = {use.name: use.share for use in table_.uses}
    assert {use.name: use.share for use in bag.uses} == pytest.approx(shares, abs=NANOSECOND)


def scaled(name, factor):
    return lambda plan: plan | {name: factor * plan[name]}


def jumped(plan):
    q = plan["q.left/elbow"].copy()
    q[50:] += 0.01
    return plan | {"q.left/elbow": q}


DAMAGES = {
    "torque": (scaled("tau.left/elbow", 1.02), "torque residual", "left/elbow"),
    "wrench": (scaled("F.right/fz", 1.02), "balance residual", "object/fz"),
    "velocity": (scaled("dq.left/elbow", 1.3), "torque residual", "left/shoulder_lift"),
    "jump": (jumped, "grasp distance", "left/"),
    "half": (lambda plan: {name: values[:60] for name, values in plan.items()}, "end velocity", "left/elbow"),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damage_is_found(damage, dual_ur5, plan, tmp_path):
    change, kind, element = DAMAGES[damage]
    found = mrts.check_plan(dual_ur5, table(tmp_path / "plan.csv", change(plan)))
    assert found.status == "impossible"
    assert share(found, kind, element) > 1
    assert bool(found.contradictions) == (damage in {"velocity", "jump"})
    if damage == "torque":
        worst = found.passed[0]
        assert (len(found.passed), found.place(worst)) == (1, str(1 + np.argmax(np.abs(plan["tau.left/elbow"]))))
        off = 0.02 * np.max(np.abs(plan["tau.left/elbow"]))
        assert worst.largest == pytest.approx(off, rel=SAME)


def test_a_joint_past_its_range_is_found(planar_cell, lifted, tmp_path):
    given = trajectory_columns(lifted)
    elbow = given["q.left/elbow"]
    lower, upper = np.min(elbow) + 0.1, np.max(elbow) + 1.0
    range_ = {"position_lower": np.array([-9, lower, -9]), "position_upper": np.array([9, upper, 9])}
    left, right = planar_cell.robots
    narrow = replace(planar_cell, robots=(replace(left, **range_), right))
    found = mrts.check_plan(narrow, table(tmp_path / "plan.csv", given))
    assert [str(use.name) for use in found.passed] == ["left/elbow position"]
    assert found.passed[0].share == pytest.approx(1 + 0.1 / ((upper - lower) / 2), rel=SAME)
    assert found.passed[0].time == pytest.approx(found.time[np.argmin(elbow)], abs=np.max(np.diff(found.time)))


def test_jumps_of_the_fastest_timing_are_rounded_off_between_the_rows(planar_cell, lift, tmp_path):
    fastest = mrts.retime(planar_cell, lift).retimed
    found = mrts.check_plan(planar_cell, table(tmp_path / "plan.csv", trajectory_columns(fastest)))
    worst = found.passed[0]
    assert (found.status, worst.name.kind) == ("impossible", "torque")
    assert "to" in found.place(worst)
    assert worst.share > 1.1


@pytest.mark.parametrize("make", [gantries, uphill_gantries])
def test_sliding_joints_without_gravity_or_with_friction_are_fine(make, tmp_path):
    """No moment acts on the object, and some joints stand still: there is little to compare rounding with."""
    cell = make(tmp_path, velocity=0.1) if make is gantries else make(tmp_path)
    result = mrts.scale(cell, along_x())
    assert mrts.check_plan(cell, table(tmp_path / "plan.csv", trajectory_columns(result))).status == "fine"


def test_dry_friction_of_joints_at_rest_is_no_residual(lift, tmp_path):
    cell = mrts.load_cell(cell_file(tmp_path, shipped(motors={"friction": {"coulomb": 2.0}})))
    result = mrts.scale(cell, lift)
    found = mrts.check_plan(cell, table(tmp_path / "plan.csv", trajectory_columns(result)))
    assert result.trajectory.has_friction
    assert found.status == "fine"
    assert share(found, "torque residual") < SAME


@pytest.mark.parametrize(
    ("kept", "dropped", "key"),
    [
        (("q", "dq", "ddq", "tau"), None, "'F.…'"),
        (("q", "ddq"), None, "'dq.…'"),
        (PARTS, "tau.left/elbow", "tau.left/elbow"),
        (PARTS, "q.left/elbow", "q.left/elbow"),
    ],
)
def test_incomplete_tables_are_refused(kept, dropped, key, dual_ur5, plan, tmp_path):
    given = {name: values for name, values in plan.items() if name != dropped}
    with pytest.raises(InputError, match=key):
        mrts.check_plan(dual_ur5, table(tmp_path / "plan.csv", given, kept))


@pytest.mark.quick
def test_the_command_line_tells_it(plan, tmp_path):
    sound = table(tmp_path / "plan.csv", plan)
    late = table(tmp_path / "late.csv", plan | {"t": 0.5 * plan["t"]})
    cell = UR5 / "cell.yaml"
    answer = mrts_command("check", sound, "--cell", cell)
    assert (answer.returncode, answer.stderr) == (0, "")
    refused = mrts_command("check", late, "--cell", cell, "-q", "--json", "-")
    told = json.loads(refused.stdout)
    assert (refused.returncode, told["status"]) == (1, "impossible")
    assert told["limits"][0]["share"] > 1
    every, some = (mrts_command("check", sound, "--cell", cell, *more).stdout for more in (["-v"], []))
    assert every.count("\n") > some.count("\n")
    assert "--cell" in mrts_command("check", sound).stderr
    for wrong in ([], ["--cell", cell, "--closure", "1"], [cell, "--cell", cell], ["--closure", "0.001"]):
        assert mrts_command("check", sound, *wrong).returncode == 2

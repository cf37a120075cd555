"""`mrts simulate` as it is typed: plans from results, tables and bags alike, exit codes, and what it refuses."""

import json

import numpy as np
import pytest
from command_line import mrts_command
from shipped_cells import DATA

import mrts
from mrts.control import simulate as simulation
from mrts.control.plan_file import load_plan

CELL = DATA / "planar_dual_arm" / "cell.yaml"


@pytest.fixture(scope="module")
def plans(tmp_path_factory):
    """The fastest plan, and a slow one with half of the limits in reserve."""
    folder = tmp_path_factory.mktemp("plans")
    cell, lift = mrts.load_cell(CELL), mrts.load_motion(CELL.parent / "lift.yaml")
    fast = mrts.scale(cell, lift)
    mrts.save_result(fast, folder / "fast.npz")
    mrts.write_trajectory_csv(fast, folder / "fast.csv")
    mrts.write_ros_bag(fast, folder / "bag")
    mrts.save_result(mrts.scale(cell.without_wrench_limits(), lift, select=0.2), folder / "slow.npz")
    return folder


def test_results_tables_and_bags_are_one_plan(plans, planar_cell):
    whole = mrts.load_result(plans / "fast.npz").trajectory
    for name in ("fast.csv", "bag"):
        read = load_plan(planar_cell, plans / name)
        assert read.holding.ends == whole.holding.ends
        for ours, theirs in (
            (read.q, whole.q), (read.torque, whole.torque), (read.wrench, whole.wrench),
            (read.holding.torque, whole.holding.torque), (read.time, whole.time),
        ):  # fmt: skip
            np.testing.assert_allclose(ours, theirs, atol=1e-8)


def test_passed_limits_are_exit_code_1(plans, tmp_path):
    target = tmp_path / "found.json"
    done = mrts_command("simulate", CELL, plans / "fast.csv", "--set", "mass=0.1", "--json", target, "--trials", "1")
    assert (done.returncode, done.stderr) == (1, "")
    found = json.loads(target.read_text())
    assert not found["kept"]
    assert found["errors"]["mass"] == 0.1
    assert [limit["used"] for limit in found["limits"]] == sorted((x["used"] for x in found["limits"]), reverse=True)
    assert len(found["trials"]["largest"]) == 1
    assert f"{found['outcome']}\n" in done.stdout


def test_kept_limits_are_exit_code_0_and_are_drawn(plans, tmp_path):
    page, plots = tmp_path / "page.html", tmp_path / "plots"
    done = mrts_command("simulate", CELL, plans / "slow.npz", "-v", "--plot", plots, "--report", page)
    assert done.returncode == 0
    assert "robots[0].wrench_lower[0] = -inf (now -2.0)" in done.stderr  # it was made without limits of wrenches
    assert (plots / "simulation.png").stat().st_size > 10_000
    assert page.read_text().count('id="plot-simulation-') == 8
    assert len(done.stdout.splitlines()) > simulation.NEAREST + 6


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--set", "rate=0"), "rate"),
        (("--set", "delay=nan"), "delay"),
        (("--set", "speed=1"), "speed"),
        (("--set", "mass"), "KEY=VALUE"),
        (("--set", "friction=maybe"), "true or false"),
        (("--trials", "-1"), "--trials"),
    ],
)
def test_wrong_numbers_are_exit_code_2(plans, words, told):
    done = mrts_command("simulate", CELL, plans / "fast.npz", *words)
    assert done.returncode == 2
    assert told in done.stderr


def test_plans_of_other_cells_and_incomplete_ones_are_refused(plans, tmp_path):
    other = DATA / "dual_ur5" / "cell.yaml"
    table = np.loadtxt(plans / "fast.csv", delimiter=",", dtype=str)
    keep = [column for column, name in enumerate(table[0]) if not name.startswith("F.")]
    np.savetxt(tmp_path / "bare.csv", table[:, keep], delimiter=",", fmt="%s")
    wrong = [(other, plans / name) for name in ("fast.npz", "fast.csv", "bag")]
    for cell, plan in (*wrong, (CELL, tmp_path / "bare.csv")):
        done = mrts_command("simulate", cell, plan)
        assert done.returncode == 2
        assert str(plan) in done.stderr

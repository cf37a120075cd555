"""Saved results: the same answers again, without a compiler; files of smooth timing keep its rates."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import yaml
from casadi_cells import casadi_cell
from conftest import DATA
from random_motors import with_all_rates
from same_cells import same_cell
from shipped_cells import shipped, still_motion
from shown_results import result_of, with_changes

import mrts
from mrts.limits.cell_limits import torque_limits
from mrts.output.report_page import report_html
from mrts.output.trajectory_table import played_rows
from mrts.plots.card import answer_card, answer_lines

OTHERS = {
    "chosen": lambda cell, lift: mrts.scale(cell, lift, 0.5, weights=np.arange(1.0, 7.0), formulation="torque"),
    "prescribed": lambda cell, lift: mrts.scale(
        cell, lift, 1.0, sharing=mrts.LoadSharing(internal_wrench=np.zeros((101, 6)))
    ),
    "grid": lambda cell, lift: mrts.scale(cell.with_variation(mass=(0.2, 6.0)), lift, load="grid:4"),
    "outer hull": lambda cell, lift: mrts.scale(cell.with_variation(mass=(0.5, 2), mx=(-0.1, 0.05)), lift),
    "carried": lambda cell, lift: mrts.torques_for_load(
        mrts.scale(cell.with_variation(mass=(0.2, 6.0), mx=(-0.1, 0.1)), lift), cell.load + 0.05 * np.eye(10)[1]
    ),
    "what if of a timing": lambda cell, lift: replace(
        (found := mrts.retime(cell, lift)).retimed, changes=found.what_if()
    ),
}
"""Results beside those that people look at."""

LOOKED_AT = ("planar", "infeasible", "empty", "unbounded", "guaranteed", "possible", "sliding joints", "what if")


@pytest.mark.parametrize("kind", [*LOOKED_AT, *OTHERS])
def test_everything_comes_back(kind, planar_cell, lift, tmp_path):
    make = OTHERS.get(kind, lambda cell, motion: result_of(kind, cell, None, motion, tmp_path))
    result = make(planar_cell, lift)
    mrts.save_result(result, tmp_path / "result.npz")
    again = mrts.load_result(tmp_path / "result.npz")
    assert again.json_text() == result.json_text()
    assert same_cell(again.cell, result.cell)
    assert list(answer_lines(again, answer_card(again))) == list(answer_lines(result, answer_card(result)))
    mrts.save_result(again, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "result.npz").read_bytes()


def test_reading_needs_neither_compiler_nor_symbolic_layer(lifted, tmp_path):
    mrts.save_result(lifted, tmp_path / "result.npz")
    script = (
        "import sys, mrts; result = mrts.load_result(sys.argv[1]); print(result.summary()); result.to_json();"
        "print([name for name in ('casadi', 'mrts_codegen', 'yourdfpy', 'lxml') if name in sys.modules])"
    )
    command = [sys.executable, "-c", script, tmp_path / "result.npz"]
    environment = {"PATH": "", "MRTS_CACHE_DIR": str(tmp_path / "unused"), "PYTHONPATH": ":".join(sys.path)}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.splitlines() == [lifted.summary(), "[]"]
    assert not (tmp_path / "unused").exists()


def test_the_functions_come_from_the_cell_that_is_given(planar_cell, lift, tmp_path):
    box = planar_cell.without_wrench_limits().with_variation(mass=(0.2, 6.0))
    result = mrts.scale(box, lift)
    mrts.save_result(result, tmp_path / "result.npz")
    alone = mrts.load_result(tmp_path / "result.npz")
    for asked in (
        alone.residuals,
        lambda: mrts.torques_for_load(alone, box.load),
        lambda: mrts.follow_object(alone.cell, lift),
        lambda: mrts.scale(alone.cell, alone.motion),
    ):
        with pytest.raises(mrts.InputError, match=r"result\.npz: functions: .*load_result\(path, cell=mrts\.load"):
            asked()
    whole = mrts.load_result(tmp_path / "result.npz", cell=planar_cell)
    assert whole.cell.library is planar_cell.library
    assert (whole.cell.folder, alone.cell.folder) == (planar_cell.folder, None)
    assert same_cell(result.cell, whole.cell)
    assert whole.residuals() == result.residuals()
    assert (
        mrts.torques_for_load(whole, box.load * 0.5).to_json()
        == mrts.torques_for_load(result, box.load * 0.5).to_json()
    )


def test_another_cell_is_refused(lifted, dual_ur5, planar_cell, tmp_path):
    mrts.save_result(lifted, tmp_path / "result.npz")
    description = shipped("planar_dual_arm", torque=[1, 1, 1])  # limits do not enter the functions
    (tmp_path / "weak.yaml").write_text(yaml.safe_dump(description))
    whole = mrts.load_result(tmp_path / "result.npz", cell=mrts.load_cell(tmp_path / "weak.yaml"))
    np.testing.assert_array_equal(whole.cell.robots[0].torque_upper, planar_cell.robots[0].torque_upper)
    assert max(whole.residuals().arms, whole.residuals().object) < 1e-9
    description["robots"][1]["base"]["xyz"][0] += 0.001  # an input of the functions
    (tmp_path / "moved.yaml").write_text(yaml.safe_dump(description))
    whole = mrts.load_result(tmp_path / "result.npz", cell=mrts.load_cell(tmp_path / "moved.yaml"))
    np.testing.assert_array_equal(whole.cell.geometry, planar_cell.geometry)
    assert max(whole.residuals().arms, whole.residuals().object) < 1e-9
    text = (DATA / "planar_arm.urdf").read_text().replace('mass value="', 'mass value="1')
    (tmp_path / "heavier.urdf").write_text(text)
    description["robots"][1]["urdf"] = "heavier.urdf"
    (tmp_path / "heavier.yaml").write_text(yaml.safe_dump(description))
    for cell, what in ((dual_ur5, "plane"), (casadi_cell(tmp_path / "heavier.yaml"), "robot 'right' urdf")):
        with pytest.raises(mrts.InputError, match=rf"cell: .*they differ in {what}.* Read the cell file"):
            mrts.load_result(tmp_path / "result.npz", cell=cell)
    with pytest.raises(mrts.InputError, match=r"cell = .*: must be of type Cell or None; it is of type PosixPath\.$"):
        mrts.load_result(tmp_path / "result.npz", cell=DATA / "cell.yaml")


def test_other_limits_of_python_than_it_was_found_with_are_refused(planar_cell, lift, lifted, tmp_path):
    usual, own = tmp_path / "usual.npz", tmp_path / "own.npz"
    mrts.save_result(lifted, usual)
    limited = planar_cell.with_limits(torque_limits)
    mrts.save_result(mrts.scale(limited, lift), own)
    for path, cell in ((usual, None), (usual, planar_cell), (own, limited)):
        assert mrts.load_result(path, cell=cell).warnings == ()
    for path, cell in ((usual, limited), (own, None), (own, planar_cell)):
        with pytest.raises(mrts.InputError, match=r"limits.*torque_limits of Python"):
            mrts.load_result(path, cell=cell)


TIMINGS = {
    "fastest": mrts.retime,
    "smooth": lambda cell, motion: mrts.retime(cell, motion, rates=11.5),
    "of a box": lambda cell, motion: mrts.retime(cell.with_variation(mass=(0.2, 6.0)), motion),
    "what if": lambda cell, motion: with_changes(mrts.retime(cell, motion)),
    "infeasible": lambda cell, motion: mrts.retime(cell.with_mass(60.0), motion),
    "no path": lambda cell, motion: mrts.retime(cell, still_motion(motion.position[0])),
}


@pytest.mark.parametrize("timing", TIMINGS)
def test_a_timing_comes_back_whole(timing, planar_cell, lift, tmp_path):
    found = TIMINGS[timing](planar_cell, lift)
    mrts.save_result(found, tmp_path / "timing.npz")
    again = mrts.load_result(tmp_path / "timing.npz")
    assert type(again) is mrts.RetimingResult
    assert again.json_text() == found.json_text()
    assert list(answer_lines(again, answer_card(again))) == list(answer_lines(found, answer_card(found)))
    assert report_html(again) == report_html(found)
    assert again.options == found.options
    mrts.save_result(again, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "timing.npz").read_bytes()


ROUNDING = 1e-6
"""Share by which a difference of two rows may pass a rate: rounding and what programs are solved to."""

EXACT = 1e-9
"""Largest residual of the dynamics [N m, N], as of every result."""

NO_FASTER = 1e-4
"""By how much the largest c² within the rates may be off 1: the linear programs of the constant factor ask what torques
there are, the timing was found for by an interior point that comes near its limits, not to them."""


def check_rates(result, kept):
    """That differences of neighbouring rows keep what was asked for, by no code of the programs."""
    rows = played_rows(result.trajectory)
    steps = np.diff(rows["t"])[:, None]
    for values, limits in ((rows["tau"], kept.torque), (rows["F"], kept.wrench)):
        assert np.max(np.abs(np.diff(values, axis=0)) / steps / limits) <= 1 + ROUNDING


def test_a_table_read_back_can_be_played_as_fast_and_no_faster_within_its_rates(
    smooth, dual_ur5, lift_and_turn, tmp_path
):
    asked = {"rates": 11.0, "between": None}
    for found in (smooth, mrts.retime(dual_ur5, lift_and_turn, **asked, distribute="least-torque")):
        mrts.write_trajectory_csv(found.retimed, tmp_path / "trajectory.csv")
        again = mrts.scale(found.cell, mrts.load_motion(tmp_path / "trajectory.csv"), **asked)
        assert again.range.upper.c2 == pytest.approx(1, abs=NO_FASTER)
        assert {row.name.kind for row in again.range.upper.rows} & {"torque rate", "wrench rate"}
        assert not any(warning.code == "step-at-ends" for warning in again.warnings)


def test_torques_for_another_load_keep_the_rates_or_are_refused(planar_cell, lift):
    cell = with_all_rates(planar_cell.with_variation(mass=(0.2, 3.0)))
    found = mrts.retime(cell, lift, rates=11.0)
    assert len(found.loads) == 2
    for mass in (0.2, 1.7, 3.0):
        carried = mrts.torques_for_load(found.retimed, cell.load_box.load_at({"mass": mass}))
        check_rates(carried, found.options.rates)
        assert carried.cell.mass == pytest.approx(mass * cell.mass)
        residuals = carried.residuals()
        assert max(residuals.arms, residuals.object) < EXACT
    too_much = cell.load_box.load_at({"mass": 3.0}) * 1.5
    with pytest.raises(mrts.SelectionError, match="does not suit this load where rates are kept") as caught:
        mrts.torques_for_load(found.retimed, too_much)
    assert caught.value.result.trajectory is None
    alone = cell.load_box.load_at({"mass": 1.7})
    bare = mrts.torques_for_load(mrts.retime(planar_cell.with_load(alone), lift).retimed, alone)
    with pytest.raises(AssertionError):
        check_rates(bare, found.options.rates)  # a bang-bang timing does not keep them

"""Saved results: the same answers again, without a compiler; and every way in which a file can be wrong."""

import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest
import yaml
from casadi_cells import casadi_cell
from cell_bank import random_planar_cell, random_spatial_cell
from conftest import DATA, ROOT
from saved_files import contents

import mrts
from mrts.cli import main
from mrts.limits.cell_limits import torque_limits
from mrts.limits.row_check import limit_name
from mrts.output.summary_lines import retiming_lines, scaling_lines
from mrts.output.trajectory_table import trajectory_csv
from mrts.plots import range_plot, trajectory_plot, write_plot
from mrts.plots.card import answer_card
from mrts.report import report_html

UR5 = DATA.parent / "dual_ur5"


def lowering(lift):
    """The motion of the shipped lift, downward."""
    fields = (lift.time, lift.position[::-1], lift.rotation[::-1], -lift.twist[::-1], lift.acceleration[::-1])
    return mrts.ObjectMotion(*fields)


def forks(cell):
    """Grippers that hold with 1 N <= f_y <= 3 N."""
    ends = [np.array([-np.inf, 1.0, -np.inf]), np.array([np.inf, 3.0, np.inf])]
    robots = (replace(robot, wrench_lower=ends[0], wrench_upper=ends[1]) for robot in cell.robots)
    return replace(cell, robots=tuple(robots))


def still(lift):
    return mrts.ObjectMotion(lift.time, lift.position * 0 + lift.position[0], lift.rotation, lift.twist * 0,
                             lift.acceleration * 0)  # fmt: skip


CASES = {
    "free": mrts.scale,
    "chosen": lambda cell, lift: mrts.scale(cell, lift, 0.5, weights=np.arange(1.0, 7.0), formulation="torque"),
    "fixed": lambda cell, lift: mrts.scale(cell, lift, sharing=mrts.LoadSharing([0.4, 0.6])),
    "prescribed": lambda cell, lift: mrts.scale(
        cell, lift, 1.0, sharing=mrts.LoadSharing(internal_wrench=np.zeros((101, 6)))
    ),
    "changed": lambda cell, lift: mrts.scale(cell.without_wrench_limits().with_mass(2.0), lift, load="nominal"),
    "postures": lambda cell, lift: mrts.scale(cell.with_postures({"left": cell.robots[0].posture + 0.01}), lift),
    "guaranteed": lambda cell, lift: mrts.scale(cell.with_variation(mass=(0.2, 6.0), izz=(0.5, 2)), lift),
    "in closed form": lambda cell, lift: mrts.scale(
        cell.with_variation(mass=(0.2, 6.0), izz=(0.5, 2)), lift, sharing=mrts.LoadSharing()
    ),
    "grid": lambda cell, lift: mrts.scale(cell.with_variation(mass=(0.2, 6.0)), lift, load="grid:4"),
    "possible": lambda cell, lift: mrts.scale(
        cell.with_variation(mass=(0.2, 20.0), mx=(-0.1, 0.1)), lift, load="possible"
    ),
    "outer hull": lambda cell, lift: mrts.scale(
        cell.with_variation(mass=(0.5, 2), com_x=(-0.1, 0.05), outer_hull=True), lift
    ),
    "carried": lambda cell, lift: mrts.torques_for_load(
        mrts.scale(cell.with_variation(mass=(0.2, 6.0), mx=(-0.1, 0.1)), lift), cell.load + 0.05 * np.eye(10)[1]
    ),
    "infeasible": lambda cell, lift: mrts.scale(cell.with_mass(60.0), lift),
    "no load of the box": lambda cell, lift: mrts.scale(cell.with_variation(mass=(0.2, 200.0)), lift),
    "empty": lambda cell, lift: mrts.scale(forks(cell).with_variation(mass=(0.45, 2.0)), until_braking(lowering(lift))),
    "unbounded": lambda cell, lift: mrts.scale(cell, still(lift)),
    "what if": lambda cell, lift: asked(mrts.scale(cell.with_mass(7.0), lift), share=0.8, shift=0.9),
    "what if nothing limits": lambda cell, lift: asked(mrts.scale(cell, still(lift))),
    "what if of a timing": lambda cell, lift: replace(
        (found := mrts.retime(cell, lift)).retimed, changes=found.what_if(share=0.2)
    ),
}


def asked(result, **steps):
    """The result with what changes to its cell would do."""
    return replace(result, changes=result.what_if(**steps))


def until_braking(motion):
    """The first 20 samples."""
    parts = ("time", "position", "rotation", "twist", "acceleration")
    return mrts.ObjectMotion(*(getattr(motion, part)[:20] for part in parts))


@pytest.fixture(scope="module", params=CASES)
def result(request, planar_cell, lift):
    return CASES[request.param](planar_cell, lift)


FOUND_WHEN_READ = {
    "Excess.named": ("row",),
    "RangeEnd.named": ("rows",),
    "ScalingResult.found": ("range",),
    "SampleRanges.codes": (),  # a file has all rows at the ends over the motion: what is saved again is compared
    "SampleRanges.problem": (),
}
"""Fields that hold what finds a value, and where the value is."""


def differences(one, other, path="result"):
    """Where values of dataclasses, sequences, mappings and arrays differ; functions, courses, folders do not count."""
    if isinstance(one, np.ndarray):
        same = isinstance(other, np.ndarray) and one.shape == other.shape and np.array_equal(one, other)
        return [] if same else [path]
    if isinstance(one, Mapping):
        parts = [] if list(one) == list(other) else [("keys", 0, 1)]
        parts += [(name, one[name], other[name]) for name in one if name in other]
    elif isinstance(one, Sequence) and not isinstance(one, str):
        parts = [("size", len(one), len(other)), *zip(range(len(one)), one, other, strict=False)]
    elif is_dataclass(one):
        names = [field.name for field in fields(one) if field.name not in {"functions", "course", "folder"}]
        kind = type(one).__name__
        found = [FOUND_WHEN_READ.get(f"{kind}.{name}", FOUND_WHEN_READ.get(name, (name,))) for name in names]
        names = [read for reads in found for read in reads]
        parts = [(name, getattr(one, name), getattr(other, name)) for name in names]
    else:
        return [] if one == other else [path]
    return [found for name, a, b in parts for found in differences(a, b, f"{path}.{name}")]


def test_everything_comes_back(result, tmp_path):
    mrts.save_result(result, tmp_path / "result.npz")
    again = mrts.load_result(tmp_path / "result.npz")
    assert differences(result, again) == []
    assert again.json_text() == result.json_text()
    assert again.to_json() == result.to_json()
    assert list(scaling_lines(again, answer_card(again))) == list(scaling_lines(result, answer_card(result)))
    mrts.save_result(again, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "result.npz").read_bytes()


def test_the_rule_comes_back(planar_cell, lift, tmp_path):
    B = planar_cell.functions("terms", 101, mrts.follow_object(planar_cell, lift).inputs(planar_cell.load))["B"]
    inner = np.linalg.svd(B)[2][:, -1]  # B inner = 0 at every sample
    sharing = mrts.LoadSharing(np.array([0.3, 0.7]), inner)
    mrts.save_result(mrts.scale(planar_cell, lift, 0.5, sharing=sharing), tmp_path / "result.npz")
    again = mrts.load_result(tmp_path / "result.npz").options
    np.testing.assert_array_equal(again.sharing.shares, [0.3, 0.7])
    np.testing.assert_array_equal(again.sharing.internal_wrench, inner)
    W = np.diag(np.arange(1.0, 7.0))
    for formulation, weights in (("torque", W), ("wrench", np.diag(W))):
        chosen = mrts.scale(planar_cell, lift, 0.5, formulation=formulation, weights=weights)
        mrts.save_result(chosen, tmp_path / "result.npz")
        again = mrts.load_result(tmp_path / "result.npz").options
        assert (again.sharing, again.formulation) == (None, formulation)
        np.testing.assert_array_equal(again.weights, weights)


@pytest.mark.quick
@pytest.mark.parametrize("make", [random_planar_cell, random_spatial_cell])
@pytest.mark.parametrize("arms", [1, 4])
def test_any_number_of_arms_and_sliding_joints_come_back(make, arms, tmp_path):
    case = make(np.random.default_rng([11, arms]), tmp_path, arms)
    cell = case.cell
    result = mrts.scale(cell, case.motion)
    mrts.save_result(result, tmp_path / "result.npz")
    again = mrts.load_result(tmp_path / "result.npz")
    assert again.json_text() == result.json_text()
    assert differences(result.cell, again.cell) == []
    assert [robot.torque_units for robot in again.cell.robots] == [robot.torque_units for robot in cell.robots]


def test_what_is_made_of_a_result_is_the_same(dual_ur5, tmp_path):
    result = mrts.scale(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml"))
    mrts.save_result(result, tmp_path / "result.npz")
    again = mrts.load_result(tmp_path / "result.npz")
    assert trajectory_csv(again) == trajectory_csv(result)
    np.testing.assert_array_equal(again.trajectory.internal_wrench, result.trajectory.internal_wrench)
    for name, of in (("one", result), ("two", again)):
        (tmp_path / name).mkdir()
        mrts.write_ros_bag(of, tmp_path / name / "bag")
        write_plot(range_plot(of), tmp_path / name / "range.png")
        write_plot(trajectory_plot(of, "title"), tmp_path / name / "trajectory.png")
    for file in ("bag/bag.mcap", "range.png", "trajectory.png"):
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes(), file


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
    assert differences(result.cell, whole.cell) == []
    assert whole.residuals() == result.residuals()
    assert (
        mrts.torques_for_load(whole, box.load * 0.5).to_json()
        == mrts.torques_for_load(result, box.load * 0.5).to_json()
    )


def test_another_cell_is_refused(lifted, dual_ur5, planar_cell, tmp_path):
    mrts.save_result(lifted, tmp_path / "result.npz")
    description = yaml.safe_load((DATA / "cell.yaml").read_text())
    for robot in description["robots"]:
        robot["urdf"] = str(DATA / "planar_arm.urdf")
        robot["torque"] = [1, 1, 1]  # limits do not enter the functions
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
    for cell, what in ((dual_ur5, "plane"), (casadi_cell(tmp_path / "heavier.yaml"), "robots.1.")):
        with pytest.raises(mrts.InputError, match=rf"cell: .*they differ in {what}.* Read the cell file"):
            mrts.load_result(tmp_path / "result.npz", cell=cell)
    with pytest.raises(mrts.InputError, match=r"cell.*from mrts\.load_cell"):
        mrts.load_result(tmp_path / "result.npz", cell=DATA / "cell.yaml")


def test_what_cannot_be_saved_leaves_the_old_file(lifted, tmp_path):
    path = tmp_path / "result.npz"
    mrts.save_result(lifted, path)
    before = path.read_bytes()
    with pytest.raises(mrts.InputError, match="cannot be written"):
        mrts.save_result(lifted, path / "below")
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["result.npz"]


def test_a_factor_without_torques_comes_back(planar_cell, lift, tmp_path):
    factor = mrts.retime(planar_cell, lift).factor
    mrts.save_result(factor, tmp_path / "factor.npz")
    again = mrts.load_result(tmp_path / "factor.npz")
    assert (again.c2, again.trajectory) == (factor.c2, None)
    assert again.json_text() == factor.json_text()


def test_a_joint_without_a_limit_comes_back(lifted, tmp_path):
    robots = tuple(replace(robot, torque_upper=robot.torque_upper * np.inf) for robot in lifted.cell.robots)
    mrts.save_result(replace(lifted, cell=replace(lifted.cell, robots=robots)), tmp_path / "result.npz")
    assert np.all(mrts.load_result(tmp_path / "result.npz").cell.robots[0].torque_upper == np.inf)


def test_the_command_line_saves(tmp_path, capsys):
    command = ["scale", str(DATA / "cell.yaml"), str(DATA / "lift.yaml"), "--save", str(tmp_path / "deep" / "r.npz")]
    assert main(command) == 0
    again = mrts.load_result(tmp_path / "deep" / "r.npz")
    written = ["", "written:", f"  {tmp_path / 'deep' / 'r.npz'}", ""]
    assert capsys.readouterr().out == "\n".join([*scaling_lines(again, answer_card(again)), *written])
    assert main([*command, "--c2", "99"]) == 2  # the range is saved all the same
    assert mrts.load_result(tmp_path / "deep" / "r.npz").trajectory is None


def test_other_limits_than_it_was_found_with_are_told(planar_cell, lift, lifted, tmp_path):
    usual, own = tmp_path / "usual.npz", tmp_path / "own.npz"
    mrts.save_result(lifted, usual)
    limited = planar_cell.with_limits(torque_limits)
    mrts.save_result(mrts.scale(limited, lift), own)
    for path, cell, codes in (
        (usual, None, []),
        (usual, planar_cell, []),
        (usual, limited, ["other-limits"]),
        (own, None, ["other-limits"]),
        (own, limited, []),
    ):
        found = mrts.load_result(path, cell=cell)
        assert [remark.code for remark in found.warnings] == codes
        if codes:
            with pytest.raises(mrts.InputError) as refused:
                found.what_if()
            assert refused.value.where == "what_if"


def test_names_of_limits_that_a_file_cannot_hold_last(planar_cell, lift, tmp_path):
    limited = planar_cell.with_limits(torque_limits)
    mrts.save_result(mrts.scale(limited, lift), tmp_path / "first.npz")
    mrts.save_result(mrts.load_result(tmp_path / "first.npz"), tmp_path / "second.npz")
    alone = mrts.load_result(tmp_path / "second.npz")
    assert [limit_name(limit) for limit in alone.cell.limits] == ["torque_limits"]
    assert [remark.code for remark in alone.warnings] == ["other-limits"]
    assert mrts.load_result(tmp_path / "second.npz", cell=limited).warnings == ()


TIMINGS = {
    "fastest": mrts.retime,
    "smooth": lambda cell, motion: mrts.retime(cell, motion, rates=11.5),
    "of a box": lambda cell, motion: mrts.retime(cell.with_variation(mass=(0.2, 6.0)), motion),
    "what if": lambda cell, motion: asked(mrts.retime(cell, motion), share=0.2),
    "infeasible": lambda cell, motion: mrts.retime(cell.with_mass(60.0), motion),
    "no path": lambda cell, motion: mrts.retime(cell, still(motion)),
}


@pytest.mark.parametrize("timing", TIMINGS)
def test_a_timing_comes_back_whole(timing, planar_cell, lift, tmp_path):
    found = TIMINGS[timing](planar_cell, lift)
    mrts.save_result(found, tmp_path / "timing.npz")
    again = mrts.load_result(tmp_path / "timing.npz")
    assert type(again) is mrts.RetimingResult
    assert again.json_text() == found.json_text()
    assert list(retiming_lines(again, answer_card(again))) == list(retiming_lines(found, answer_card(found)))
    assert report_html(again) == report_html(found)
    assert again.options == found.options
    mrts.save_result(again, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "timing.npz").read_bytes()


def test_a_study_of_many_loads_comes_back(planar_cell, lift, tmp_path):
    result = mrts.scale(planar_cell.with_variation(mass=(0.2, 6.0)), until_braking(lift), load="grid:400", between=None)
    mrts.save_result(result, tmp_path / "result.npz")
    assert mrts.load_result(tmp_path / "result.npz").json_text() == result.json_text()


def test_a_timing_is_asked_again_with_its_cell(planar_cell, lift, tmp_path):
    found = mrts.retime(planar_cell, lift)
    mrts.save_result(found, tmp_path / "timing.npz")
    again = mrts.load_result(tmp_path / "timing.npz", cell=planar_cell)
    assert again.constant.to_json() == found.constant.to_json()
    assert again.what_if(share=0.2) == found.what_if(share=0.2)
    with pytest.raises(mrts.InputError, match=r"functions: .*load_result\(path, cell=mrts\.load"):
        mrts.load_result(tmp_path / "timing.npz").what_if()


def test_every_array_in_a_file_is_documented(planar_cell, lift, tmp_path):
    text = (ROOT / "docs" / "saved_results.md").read_text(encoding="utf-8")
    names = set(re.findall(r"^\| `([\w.]+)`", text, re.MULTILINE))
    mrts.save_result(mrts.scale(planar_cell, lift), tmp_path / "result.npz")
    assert set(contents(tmp_path / "result.npz")[1]) | {"description", "seal"} == names

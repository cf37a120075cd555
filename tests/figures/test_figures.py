"""Figures: they show the numbers of the result, and nothing hides anything."""

import json
import subprocess
import sys

import numpy as np
import pytest
from conftest import DATA
from legible_figures import boxes_of_texts, check_legible, lines_of
from matplotlib.figure import Figure
from shown_results import KINDS, renamed, result_of

import mrts
from mrts.cli import main
from mrts.drawing.labels import LANE_LETTERS
from mrts.drawing.lanes import binding_lanes
from mrts.figures import (
    draw_binding_rows,
    draw_contact_forces,
    draw_contact_moments,
    draw_energy,
    draw_load_study,
    draw_power,
    draw_range,
    draw_ranking,
    draw_torques,
    power_figure,
    range_figure,
    ranking_figure,
    rates_figure,
    study_figure,
    trajectory_figure,
    write_result_figures,
)

UR5 = DATA.parent / "dual_ur5"


@pytest.fixture(scope="module")
def result(planar_cell, lift):
    return mrts.scale(planar_cell, lift)


@pytest.fixture(scope="module")
def study(dual_ur5):
    return mrts.rank_configurations(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml"))


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_result_has_legible_figures(kind, planar_cell, dual_ur5, lift, tmp_path):
    found = result_of(kind, planar_cell, dual_ur5, lift, tmp_path)
    write_result_figures(found, tmp_path / "out")
    names = {path.stem for path in (tmp_path / "out").iterdir()}
    check_legible(range_figure(found))
    expected = {"c2_range"}
    if found.trajectory is not None:
        expected |= {"torques_and_wrenches", "power_and_energy"}
        check_legible(trajectory_figure(found, "title"))
        check_legible(power_figure(found, "title"))
        if kind in {"smooth", "rates"}:
            expected |= {"rates"}
            check_legible(rates_figure(found, "title"))
    if found.load is not None and found.load.points:
        expected |= {"load_study"}
        check_legible(study_figure(found))
    assert names == expected


@pytest.mark.quick
def test_curves_are_the_numbers_of_the_result(result):
    torque, force, moment, power, energy = axes = Figure().subplots(5)
    for one, draw in zip(axes, (draw_torques, draw_contact_forces, draw_contact_moments, draw_power), strict=False):
        draw(one, result, "right")
    draw_energy(energy, result)
    done = result.trajectory
    for index, joint in enumerate(("shoulder", "elbow", "wrist")):
        np.testing.assert_array_equal(lines_of(torque)[joint].get_xydata()[:, 0], done.time)
        np.testing.assert_array_equal(lines_of(torque)[joint].get_ydata(), result.torque["right"][:, index])
        np.testing.assert_array_equal(lines_of(power)[joint].get_ydata(), done.power[:, 3 + index])
    np.testing.assert_array_equal(lines_of(force)["fy"].get_ydata(), result.wrench["right"][:, 1])
    np.testing.assert_array_equal(lines_of(moment)["nz"].get_ydata(), result.wrench["right"][:, 2])
    levels = {line.get_ydata()[0] for line in torque.lines if len(line.get_ydata()) == 2}
    assert levels == {-100, 100, -80, 80, -50, 50}
    assert {line.get_ydata()[0] for line in force.lines if len(line.get_ydata()) == 2} == {-2, 2}  # fy has none
    assert lines_of(energy)[f"all: {done.energy:.4g} J"].get_ydata()[-1] == pytest.approx(done.energy)
    assert "[N m]" in torque.get_ylabel()
    assert "[W]" in power.get_ylabel()
    assert "[J]" in energy.get_ylabel()


def test_the_range_is_drawn_with_the_point_that_sets_it(planar_cell, lift, result):
    above, below = Figure().subplots(2)
    draw_range(above, result)
    draw_binding_rows(below, result)
    np.testing.assert_array_equal(lines_of(above)["c²⁺(t)"].get_ydata(), result.range.samples.upper)
    end = result.range.upper
    marks = [line.get_xydata()[0].tolist() for line in above.lines if line.get_marker() == "o"]
    assert marks == [[end.time, end.c2]]
    assert "c²⁺ = 3.062" in [text.get_text() for text in above.texts]
    assert above.get_ylim()[0] < 0 < end.c2 < above.get_ylim()[1]
    assert [label.get_text() for label in below.get_yticklabels()][:2] == ["left/elbow ↑", "right/elbow ↓"]
    bars = below.collections[1].get_paths()[0].get_extents()  # right/elbow: from the start on
    assert bars.x0 == 0
    assert bars.x1 == pytest.approx(0.144, abs=0.003)
    torn = Figure().subplots()
    draw_range(torn, mrts.scale(planar_cell.with_mass(24.0), lift))
    assert "no c² at all" in [text.get_text() for text in torn.get_legend().get_texts()]
    assert [line.get_marker() for line in torn.lines if line.get_marker() not in {"None", ""}] == ["v"]


def test_a_load_study_shows_its_worst_and_best_load(planar_cell, lift):
    uncertain = mrts.scale(planar_cell.with_variation(mass=(0.2, 6.0)), lift)
    axes = Figure().subplots()
    draw_load_study(axes, uncertain)
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert "between 2 loads" in labels
    assert "worst: mass 3 kg (c²⁺ = 1.516)" in labels
    assert "best: mass 0.1 kg (c²⁺ = 3.352)" in labels
    np.testing.assert_array_equal(lines_of(axes)["guaranteed (c²⁺ = 1.516)"].get_ydata(), uncertain.range.samples.upper)


@pytest.mark.quick
def test_what_there_is_not_cannot_be_drawn(planar_cell, lift, result):
    infeasible = mrts.scale(planar_cell.with_mass(60.0), lift)
    axes = Figure().subplots()
    for draw in (draw_torques, draw_contact_forces, draw_contact_moments, draw_power):
        with pytest.raises(ValueError, match="no trajectory"):
            draw(axes, infeasible, "left")
    with pytest.raises(ValueError, match="no trajectory"):
        draw_energy(axes, infeasible)
    with pytest.raises(ValueError, match="load is known"):
        draw_load_study(axes, result)


def test_the_ranking_has_a_bar_for_each_configuration(study):
    figure = ranking_figure(study, "dual_ur5")
    check_legible(figure)
    axes = figure.axes[0]
    widths = [bar.get_width() for bar in axes.patches]
    np.testing.assert_allclose(widths, [configuration.c2_upper for configuration in study.ranked])
    first = study.ranked[0].branches
    assert axes.get_yticklabels()[0].get_text() == f"left {first[0].number}, right {first[1].number}"


def test_infeasible_and_unlimited_configurations_are_marked(planar_cell, lift):
    infeasible = mrts.rank_configurations(planar_cell.with_mass(24.0), lift)
    figure = ranking_figure(infeasible, "planar")
    check_legible(figure)
    assert [line.get_marker() for line in figure.axes[0].lines] == ["x"] * len(infeasible.ranked)
    reasons = [text.get_text() for text in boxes_of_texts(figure)]
    assert sum(text.startswith("infeasible: ") for text in reasons) == len(infeasible.ranked) == 4
    here = {"xyz": lift.position[0].tolist()}
    description = {"duration": 1.0, "samples": 11, "profile": "quintic", "start": here, "end": here}
    still = mrts.sample_motion(mrts.MotionDescription.model_validate(description))
    unlimited = Figure().subplots()
    draw_ranking(unlimited, mrts.rank_configurations(planar_cell, still))
    assert all(bar.get_hatch() for bar in unlimited.patches)


def test_an_object_out_of_reach_gets_a_figure_that_says_so(dual_ur5):
    description = {"duration": 1.0, "profile": "quintic", "start": {"xyz": [0, 0, 3]}, "end": {"xyz": [0, 0, 3.1]}}
    motion = mrts.sample_motion(mrts.MotionDescription.model_validate(description))
    figure = ranking_figure(mrts.rank_configurations(dual_ur5, motion), "dual_ur5")
    check_legible(figure)
    assert "no configuration reaches" in "".join(text.get_text() for text in boxes_of_texts(figure))


def test_the_command_line_draws_the_ranking(tmp_path, capsys):
    files = [str(DATA / "cell.yaml"), str(DATA / "lift.yaml")]
    assert main(["configurations", *files, "--plot", str(tmp_path / "out"), "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["combinations"] == 4
    assert (tmp_path / "out" / "configurations.png").read_bytes().startswith(b"\x89PNG")


def test_figures_are_written_in_the_format_that_is_asked_for(planar_cell, lift, tmp_path, capsys):
    """An infeasible timing has figures as well: those of the best constant factor."""
    infeasible = mrts.retime(planar_cell.with_mass(60.0), lift)
    for form, start in (("svg", b"<?xml"), ("pdf", b"%PDF")):
        for folder in ("once", "again"):
            write_result_figures(infeasible, tmp_path / folder, form)
        texts = {(tmp_path / folder / f"c2_range.{form}").read_bytes() for folder in ("once", "again")}
        assert len(texts) == 1  # no date, no identifiers of chance
        assert texts.pop().startswith(start)
    assert {path.name for path in (tmp_path / "once").iterdir()} == {"c2_range.svg", "c2_range.pdf"}
    with pytest.raises(mrts.InputError, match="one of png, svg, pdf"):
        write_result_figures(infeasible, tmp_path / "once", "gif")
    files = [str(DATA / "cell.yaml"), str(DATA / "lift.yaml")]
    command = ["configurations", *files, "--plot", str(tmp_path / "out"), "--plot-format", "svg"]
    assert main(command) == 0
    assert (tmp_path / "out" / "configurations.svg").read_bytes().startswith(b"<?xml")
    with pytest.raises(SystemExit):
        main([*command[:-1], "gif"])
    assert "--plot-format" in capsys.readouterr().err
    assert main(["scale", *files, "--plot-format", "svg"]) == 2
    assert "give --plot DIR too" in capsys.readouterr().err


def test_a_missing_matplotlib_is_named_before_any_work(tmp_path):
    script = (
        "import importlib.util, sys; found = importlib.util.find_spec;"
        "importlib.util.find_spec = lambda name, *rest: None if name == 'matplotlib' else found(name, *rest);"
        "from mrts.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    command = ["configurations", str(DATA / "cell.yaml"), str(DATA / "lift.yaml"), "--plot", str(tmp_path / "out")]
    done = subprocess.run([sys.executable, "-c", script, *command], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "pip install 'mrts[plot]'" in done.stderr
    assert done.stdout == ""


def test_names_of_rows_are_whole_and_the_figure_as_wide_as_they_want(planar_cell, lift):
    joints = tuple(f"left_robot_arm_{part}_rotation_joint" for part in ("shoulder_pan", "elbow", "wrist"))
    long = renamed(planar_cell, "long", ("left_robot_arm", "right_robot_arm"), joints)
    found = mrts.scale(long, lift)
    figure = range_figure(found)
    check_legible(figure)
    shown = {label.get_text().strip() for label in figure.axes[-1].get_yticklabels()}
    assert {lane.label for lane in binding_lanes(found.range)} == shown
    assert max(map(len, shown)) > LANE_LETTERS
    assert figure.get_figwidth() > range_figure(mrts.scale(planar_cell, lift)).get_figwidth()

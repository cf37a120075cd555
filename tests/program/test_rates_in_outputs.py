"""What is said of limits of rates, kept or not: warnings, lines, JSON, saved results, the report, the command line."""

import json
from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA

import mrts
from mrts.cell.motors import JointMotors
from mrts.cli import main
from mrts.output.summary_lines import scaling_lines
from mrts.plots.card import answer_card
from mrts.plots.limit_shares import limiting_rows
from mrts.report.tables import rates_table
from mrts.scaling.limit_use import rate_uses

pytestmark = pytest.mark.quick

CELL, LIFT = str(DATA / "cell.yaml"), str(DATA / "lift.yaml")


def with_rates(cell, share=1.0):
    """Torque rates, jerks and contact rates of one robot that its fastest factor passes, for a small share."""
    left, right = cell.robots
    motors = replace(
        JointMotors.unknown(3), torque_rate=share * np.array([500.0, np.inf, 400.0]), jerk=share * np.full(3, 900.0)
    )
    return replace(
        cell, robots=(replace(left, motors=motors, contact_rate=share * np.array([60.0, 60.0, np.inf])), right)
    )


@pytest.fixture(scope="module")
def reported(planar_cell, lift):
    """Rates that are passed, and that nothing keeps."""
    return mrts.scale(with_rates(planar_cell, 0.5), lift)


@pytest.fixture(scope="module")
def kept(planar_cell, lift):
    return mrts.scale(with_rates(planar_cell, 0.5), lift, rates=True)


def test_rates_are_reported_and_bind_nothing(reported, lifted):
    assert reported.trajectory.c2 == lifted.trajectory.c2
    np.testing.assert_array_equal(reported.trajectory.torque, lifted.trajectory.torque)
    uses = rate_uses(reported)
    done, worst = reported.trajectory, uses[0]
    assert [use.share for use in uses] == sorted((use.share for use in uses), reverse=True)
    assert len(uses) == 2 + 3 + 2
    by_name = {str(use.name): use for use in uses}
    elbow = by_name["left/shoulder torque rate"]
    rates = np.abs(np.diff(done.torque[:, 0])) / np.diff(done.time)
    assert elbow.size == np.max(rates)
    assert elbow.time == done.time[np.argmax(rates)]
    duty = done.duty["left"]
    for kind, values in (("torque rate", duty.torque_rate_share), ("jerk", duty.jerk_share)):
        found = [use.share for joint in ["shoulder", "elbow", "wrist"] if (use := by_name.get(f"left/{joint} {kind}"))]
        np.testing.assert_allclose(found, [share for share in values if share > 0], rtol=1e-12)
    warning = next(one for one in reported.warnings if one.code == "rate-passed")
    assert worst.share > 1
    assert f"{worst.name} reaches {worst.size:.4g} {worst.name.unit}" in warning.text
    assert f"{100 * worst.share:.0f} % of its limit" in warning.text
    assert "--rates cell keeps them, at a speed that varies --profile smooth" in warning.text
    assert any(
        line.startswith(f"{worst.name}: {100 * worst.share:.3g} % of its limit")
        for line in scaling_lines(reported, answer_card(reported))
    )


def test_rates_that_are_kept_warn_of_nothing_but_steps_at_the_ends(kept, reported):
    assert kept.trajectory.c2 < reported.trajectory.c2
    assert rate_uses(kept)[0].share == pytest.approx(1, abs=1e-7)
    assert [one.code for one in kept.warnings] == ["step-at-ends"]
    assert "starts and ends at rest but accelerates there" in kept.warnings[0].text
    named = {row[0][0] for row in rates_table(kept, limiting_rows(kept, None)).rows}
    assert named == {str(use.name) for use in rate_uses(kept)}


def test_a_quintic_profile_has_no_step_at_its_ends(planar_cell, lift):
    description = {"duration": 0.5, "samples": 41, "profile": "quintic"}
    description |= {"start": {"xyz": lift.position[0].tolist()}, "end": {"xyz": lift.position[-1].tolist()}}
    smooth = mrts.sample_motion(mrts.MotionDescription.model_validate(description))
    assert mrts.scale(with_rates(planar_cell, 0.5), smooth, rates=True).warnings == ()


def test_a_saved_result_says_the_same(kept, tmp_path):
    mrts.save_result(kept, tmp_path / "kept.npz")
    again = mrts.load_result(tmp_path / "kept.npz")
    assert again.range.upper == kept.range.upper
    assert again.range.upper.rows == kept.range.upper.rows
    assert again.json_text() == kept.json_text()
    assert again.sentence() == kept.sentence()


def test_a_range_that_rates_leave_empty_is_saved(planar_cell, lift, tmp_path, lifted):
    """Only its form: `test_constant_rates` has an answer that is."""
    upper = lifted.range.upper
    empty = mrts.ScalingRange(mrts.ScalingStatus.EMPTY, upper, replace(upper, c2=1.0), lifted.range.samples)
    limits = mrts.scale(planar_cell, lift, rates=100.0).options
    mrts.save_result(replace(lifted, found=empty, c2=None, trajectory=None, options=limits), tmp_path / "empty.npz")
    again = mrts.load_result(tmp_path / "empty.npz")
    assert (again.range.status, again.range.lower, again.range.upper) == (empty.status, upper, replace(upper, c2=1.0))


def test_the_command_line_keeps_rates(capsys, tmp_path):
    assert main(["scale", CELL, LIFT, "--rates", "3", "--json", str(tmp_path / "result.json")]) == 0
    assert capsys.readouterr().out.startswith("planar_dual_arm: within the rates, c² ∈ [0, 1.70")
    found = json.loads((tmp_path / "result.json").read_text())
    assert found["kept_rates"]["torque"] == [300, 240, 150] * 2
    assert found["rates"][0]["share"] == pytest.approx(1, abs=1e-7)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--rates", "cell"], "the cell 'planar_dual_arm' limits no rate"),
        (["--rates", "0"], "--rates = '0': must be 'cell', or a number > 0"),
        (["--rates", "-2"], "--rates = '-2'"),
        (["--rates", "nan"], "--rates = 'nan'"),
        (["--rates", "3", "--distribute", "reserve"], "--distribute = 'reserve': with rates it must be"),
        (["--rates", "3", "--formulation", "torque"], "--formulation = 'torque': with rates it must be"),
        (["--rates", "3", "--profile", "optimal"], "--rates"),
    ],
)
def test_what_does_not_go_with_rates_is_refused(options, message, capsys):
    assert main(["scale", CELL, LIFT, *options]) == 2
    assert message in capsys.readouterr().err.replace("\n", " ")


def test_what_is_possible_keeps_no_rates(planar_cell, lift):
    with pytest.raises(mrts.InputError, match=r"load = 'possible': what is possible leaves no torques"):
        mrts.scale(planar_cell.with_variation(mass=(0.5, 2)), lift, load="possible", rates=3.0)


def test_a_chosen_factor_beyond_the_rates_is_refused(planar_cell, lift):
    with pytest.raises(mrts.SelectionError, match=r"c² = 2 is outside .*upper end is set .*torque rate"):
        mrts.scale(planar_cell, lift, 2.0, rates=3.0)
    assert mrts.scale(planar_cell, lift, 1.0, rates=3.0).trajectory.c2 == 1.0

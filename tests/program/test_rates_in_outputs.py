"""What is said of limits of rates, kept or not: warnings, lines, JSON, saved results, the report, the command line."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA

import mrts
from mrts.cell.motors.joint_motors import JointMotors
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


def test_a_chosen_factor_beyond_the_rates_is_refused(planar_cell, lift):
    with pytest.raises(mrts.SelectionError, match=r"c² = 2 is outside .*upper end is set .*torque rate"):
        mrts.scale(planar_cell, lift, 2.0, rates=3.0)
    assert mrts.scale(planar_cell, lift, 1.0, rates=3.0).trajectory.c2 == 1.0

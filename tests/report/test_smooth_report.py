"""The report of a smooth timing: what changes how fast, against its limits, and what is known of the timing."""

import numpy as np
import pytest
from report_pages import data_of
from shown_results import with_all_rates

import mrts
from mrts.report import report_html
from mrts.report.limiting import limiting_rows
from mrts.report.plots import rate_plots
from mrts.report.tables import rates_table


@pytest.fixture(scope="module")
def smooth(planar_cell, lift):
    return mrts.retime(with_all_rates(planar_cell), lift, rates=11.0)


def test_plots_hold_rates_as_steps_with_their_limits(smooth):
    plots = {plot.name: plot for plot in rate_plots(smooth.retimed)}
    kinds = ("torque-rate-{}-0", "wrench-rate-{}-0", "wrench-rate-{}-1", "jerk-{}-0")
    assert set(plots) == {kind.format(number) for kind in kinds for number in (0, 1)}
    done = smooth.retimed.trajectory
    lines = {trace["name"]: trace for trace in plots["torque-rate-1-0"].data if trace["name"]}
    rates = np.diff(smooth.retimed.torque["right"], axis=0) / np.diff(done.time)[:, None]
    for index, joint in enumerate(("shoulder", "elbow", "wrist")):
        assert lines[joint]["line"]["shape"] == "hv"
        np.testing.assert_allclose(lines[joint]["x"], done.time, rtol=1e-5)
        np.testing.assert_allclose(lines[joint]["y"][:-1], rates[:, index], rtol=1e-5)
    thin = sorted(trace["y"][0] for trace in plots["torque-rate-1-0"].data if not trace["name"])
    assert thin == [-1100, -880, -550, 550, 880, 1100]
    assert plots["wrench-rate-0-1"].layout["yaxis"]["title"]["text"] == "wrench rate [N m/s]"
    assert plots["jerk-0-0"].layout["yaxis"]["title"]["text"] == "jerk [rad/s³]"


def test_the_text_says_what_is_known_of_the_timing(smooth):
    text = report_html(smooth.retimed)
    assert str(smooth.smooth) in text  # a local optimum, its steps and its bound
    assert "smooth timing of a path that was given 0.5236 s" in text
    assert "How fast torques change" in text
    for part in rates_table(smooth.retimed, limiting_rows(smooth.retimed, None)):
        assert str(part) in text
    assert "They are kept" in text
    time = np.array(data_of(text)["player"]["time"])
    assert time[-1] == pytest.approx(smooth.duration, rel=1e-5)
    assert np.ptp(np.diff(time)) > 0.1 * np.min(np.diff(time))  # the player has the nodes' own times


def test_rates_that_nothing_limits_have_no_section(lifted):
    assert rate_plots(lifted) == []
    assert "How fast torques change" not in report_html(lifted)

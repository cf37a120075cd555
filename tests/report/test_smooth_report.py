"""The report of a smooth timing: what changes how fast, against its limits, and what is known of the timing."""

import numpy as np
import pytest
from report_pages import data_of
from shown_results import with_all_rates

import mrts
from mrts.plots.limit_shares import AT_LIMIT, all_shares, limiting_rows
from mrts.report import report_html
from mrts.report.tables import rates_table


@pytest.fixture(scope="module")
def smooth(planar_cell, lift):
    return mrts.retime(with_all_rates(planar_cell), lift, rates=11.0)


def test_rates_are_steps_in_per_cent_of_their_limits(smooth):
    plots = data_of(report_html(smooth))["plots"]
    assert "plot-c2-range" not in plots  # of a retimed motion the range answers another question
    done, limits = smooth.retimed.trajectory, np.array([1100, 880, 550])
    rates = np.abs(np.diff(smooth.retimed.torque["right"], axis=0)) / np.diff(done.time)[:, None] / limits
    lines = {trace["name"].split(":")[0]: trace for trace in plots["plot-limits-0"]["data"] if trace.get("name")}
    for index, joint in enumerate(("shoulder", "elbow", "wrist")):
        if line := lines.get(f"right/{joint}"):
            assert line["line"]["shape"] == "hv"
            np.testing.assert_allclose(line["x"], done.time, rtol=1e-5)
            np.testing.assert_allclose(line["y"][:-1], 100 * rates[:, index], rtol=1e-5)


def test_what_sets_the_speed_is_so_in_the_table_and_on_the_map(smooth):
    told = limiting_rows(smooth.retimed, smooth)
    names, shares = all_shares(smooth.retimed)
    assert told.forced.shape == shares.shape
    assert {names[row] for row in np.flatnonzero(told.forced.any(axis=0))} == set(told.setting)
    assert any(name.kind.endswith("rate") for name in told.setting)
    reached = told.forced & (shares >= 1 - AT_LIMIT)
    assert {names[row] for row in np.flatnonzero(reached.any(axis=0))} == set(told.setting)


def test_the_text_says_what_is_known_of_the_timing(smooth):
    text = report_html(smooth.retimed)
    assert str(smooth.smooth) in text  # a local optimum, its steps and its bound
    assert "smooth timing of a path that was given 0.5236 s" in text
    assert 'id="rates"' in text
    for name, *_ in rates_table(smooth.retimed, limiting_rows(smooth.retimed, None)).rows:
        assert name[0] in text
    assert "They are kept" in text
    time = np.array(data_of(text)["player"]["time"])
    assert time[-1] == pytest.approx(smooth.duration, rel=1e-5)
    assert np.ptp(np.diff(time)) > 0.1 * np.min(np.diff(time))  # the player has the nodes' own times


def test_rates_that_nothing_limits_have_no_section(lifted):
    assert 'id="rates"' not in report_html(lifted)

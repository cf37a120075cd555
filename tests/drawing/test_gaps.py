"""Several intervals of c²: every picture and text shows all of them, and where the gaps are."""

import json
from itertools import pairwise

import numpy as np
import pytest
from gantries import SLOWING, VISCOUS, intervals_uphill, slowing_down, uphill_gantries
from matplotlib.patches import Rectangle

import mrts
from mrts.drawing.lanes import binding_lanes, gap_boxes
from mrts.drawing.range_sentences import range_facts, range_text
from mrts.figures import range_figure, ranking_figure
from mrts.report.range_plot import range_plot
from mrts.report.tables import range_table
from mrts.studies.configurations import rank_configurations
from mrts.viewer.panel import moment_html, speed_html
from mrts.viewer.player_state import PlayerState

pytestmark = pytest.mark.quick

SAME = 1e-9
"""Between an end of an interval and the root of the quadratic that it is, relative."""


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    return uphill_gantries(tmp_path_factory.mktemp("gantries"))


@pytest.fixture(scope="module")
def result(cell):
    return mrts.scale(cell, slowing_down())


def gap_at(time):
    """c² between the roots of 11 c² - 2 b v c + 4 at a time, where friction takes more than inertia gives; or None."""
    b = 2 * VISCOUS * (1.5 - SLOWING * time)
    root = b * b - 4 * 11 * 4
    return None if root < 0 else tuple(((b + sign * np.sqrt(root)) / 22) ** 2 for sign in (-1, 1))


def test_the_intervals_are_those_of_the_closed_form(result):
    found = [(low.c2, high.c2) for low, high in result.range.intervals]
    np.testing.assert_allclose(found, intervals_uphill(), rtol=SAME, atol=SAME)


def test_boxes_cover_the_gaps_of_the_closed_form(result):
    samples = result.range.samples
    boxes = gap_boxes(samples, 100.0)
    for box in boxes:
        time = samples.time[np.argmin(np.abs(samples.time - (box.start + box.end) / 2))]
        np.testing.assert_allclose((box.lower, box.upper), gap_at(time), rtol=SAME)
    assert len(boxes) == sum(gap_at(time) is not None for time in samples.time)
    assert all(one.end == pytest.approx(other.start) for one, other in pairwise(boxes))
    assert all(box.upper <= 1.0 for box in gap_boxes(samples, 1.0))


def test_the_figure_has_a_band_an_interval_and_hatches_the_gaps(result):
    axes = range_figure(result).axes[0]
    hatched = [patch for patch in axes.patches if isinstance(patch, Rectangle) and patch.get_hatch()]
    assert len(hatched) == len(result.range.samples.gaps)
    bands = [patch for patch in axes.patches if isinstance(patch, Rectangle) and not patch.get_hatch()]
    spans = [(band.get_y(), band.get_y() + band.get_height()) for band in bands]
    np.testing.assert_allclose(sorted(spans), intervals_uphill(), rtol=1e-6, atol=1e-12)
    _, labels = axes.get_legend_handles_labels()
    assert sum(label.startswith("range [") for label in labels) == 1
    assert sum(label.startswith("gap") for label in labels) == 1


def test_the_report_has_them_too(result):
    plot = range_plot(result.range)
    bands = [trace for trace in plot.data if trace.get("fill") == "tonexty"]
    (gaps,) = [trace for trace in plot.data if "fillpattern" in trace]
    assert [band["y"][0] for band in bands] == [float(f"{high:.6g}") for _, high in intervals_uphill()]
    assert gaps["x"].count(None) == len(result.range.samples.gaps)
    json.dumps(plot.data, allow_nan=False)
    (table,) = range_table(result.range)
    rows = table.split("<tr>")[2:]
    assert len(rows) == 4
    for row, c2 in zip(rows, [c2 for interval in intervals_uphill() for c2 in interval], strict=True):
        assert f"<td>{c2:.6g}</td>" in row


def test_words_name_all_intervals_and_what_sets_the_gap(result):
    (_, slow), (fast, most) = intervals_uphill()
    assert range_text(result.range) == f"[0, {slow:.4g}] or [{fast:.4g}, {most:.4g}]"
    fact = range_facts(result.range)[-1]
    assert fact.startswith(f"gap from c² = {slow:.4g}, set at t = 0 s by near/slide_x ↑")
    assert f"to {fast:.4g}" in fact
    assert range_text(result.range) in result._repr_html_()


def test_lanes_have_the_rows_that_set_the_gap(result):
    lanes = {(lane.kind, lane.label): lane for lane in binding_lanes(result.range)}
    samples = result.range.samples
    with_gap = np.zeros(len(samples.time), dtype=bool)
    with_gap[[gap.sample for gap in samples.gaps]] = True
    for kind in ("upper", "lower"):
        lane = lanes[kind, "near/slide_x ↑"]
        assert lane.sets
        np.testing.assert_array_equal(lane.binds, with_gap)


def test_a_player_offers_the_slow_interval_and_knows_a_gap(cell):
    state = PlayerState(cell, slowing_down())
    (_, slow), (fast, most) = intervals_uphill()
    offered = state.speeds
    np.testing.assert_allclose(sorted(offered.ends.values()), [slow, fast, most], rtol=SAME)
    assert offered.lower < 0.5 * np.sqrt(slow)  # the slowest is standstill
    assert state.admissible
    state.choose_speed(1.0)
    assert not state.admissible
    assert "Outside the admissible range" in speed_html(state)
    state.choose_speed(0.2)
    assert state.admissible
    assert f"c² ∈ [0, {slow:.4g}] or [{fast:.4g}, " in moment_html(state)
    state.choose_time(state.trajectory.duration)
    assert " or " not in moment_html(state).split("(given")[1]


def test_a_configuration_names_its_gap_and_its_bar_has_it(cell):
    study = rank_configurations(cell, slowing_down())
    assert f"with gaps, c² ∈ {study.ranked[0].range.text()}" in study.table(5)
    intervals = json.loads(study.json_text())["ranked"][0]["intervals"]
    np.testing.assert_allclose(intervals, intervals_uphill(), rtol=SAME, atol=SAME)
    figure = ranking_figure(study, "uphill")
    widths = [patch.get_width() for patch in figure.axes[0].patches]
    np.testing.assert_allclose(widths[:2], [high - low for low, high in intervals_uphill()], rtol=1e-6)

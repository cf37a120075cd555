"""Plots of a study: they hold its numbers, and nothing hides anything."""

import numpy as np
import pytest
from found_studies import drawn_study, grid_study, kinds
from legible_figures import check_legible

from mrts.plots import durations_plot, matplotlib_figure, study_map_plot, write_study_plots
from mrts.plots.plot import Bars, Cells, HeatMap, Line, Points, Spans
from mrts.plots.study_map import LIMIT_COLOURS, duration_ends, study_map
from mrts.plots.study_plots import NO_DURATION, parallel_figure
from mrts.plots.study_words import best_part

KINDS = kinds()


def only(panel, kind):
    """The item of a kind."""
    (item,) = (item for item in panel.items if isinstance(item, kind))
    return item


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_of_study_has_legible_figures(name, tmp_path):
    table = KINDS[name]
    write_study_plots(table, tmp_path / "out")
    names = {path.stem for path in (tmp_path / "out").iterdir()}
    assert names == {"durations", "map" if len(table.knobs) > 1 else "line"}
    for plot in (durations_plot(table), study_map_plot(table)):
        check_legible(matplotlib_figure(plot))


def test_the_map_is_the_durations_of_the_best():
    table = grid_study()
    drawn = study_map(table)
    left, right = study_map_plot(table).rows[0]
    heat = only(left, HeatMap)
    np.testing.assert_array_equal(heat.z, drawn.of_best(table.duration))
    assert heat.low == np.nanmin(table.duration)
    without = only(left, Cells)
    counts = {name: np.count_nonzero(without.code == code) for code, name in enumerate(without.names)}
    missing = np.count_nonzero(np.isnan(table.duration)) - 27
    assert {name: count for name, count in counts.items() if count} == {"unreachable": 27, "infeasible": missing}
    star = only(left, Points)
    assert [star.x[0], star.y[0]] == table.values[table.ranked[0]].tolist()
    limits, _ = (item for item in right.items if isinstance(item, Cells))
    assert list(limits.names) == ["left/fx ↓", "right/elbow ↑"]
    assert np.count_nonzero(limits.code >= 0) == np.count_nonzero(np.isfinite(table.duration))
    assert len({*limits.colors}) == 2
    axes = matplotlib_figure(study_map_plot(table)).axes[0]
    assert any(line.get_paths() for line in axes.collections if "Contour" in type(line).__name__)


def test_limits_beyond_the_colours_share_the_last():
    limits = study_map_plot(KINDS["eleven limits"]).rows[0][1].items[0]
    assert len(limits.names) == len(LIMIT_COLOURS)
    assert limits.names[-1] == "5 other limits"


def test_the_line_has_what_binds_as_bands():
    table = KINDS["one number"]
    panel = study_map_plot(table).rows[0][0]
    order = np.argsort(table.values[:, 0])
    np.testing.assert_allclose(only(panel, Line).y, table.duration[order])
    (infeasible,) = (item for item in panel.items if isinstance(item, Spans) and item.label == "infeasible")
    missing = table.values[np.isnan(table.duration), 0]
    assert infeasible.ends[0][0] <= np.min(missing)
    assert infeasible.ends[-1][1] >= np.max(missing)


def test_lines_of_the_best_end_at_their_durations():
    table = drawn_study(600, 4)
    trace = parallel_figure(table)["data"][0]
    kind, ends = np.array(trace["line"]["color"]), np.array(trace["dimensions"][-1]["values"])
    (low, high), best = duration_ends(table), best_part(table)
    np.testing.assert_allclose(np.sort(low + ends[kind == 2] * (high - low)), table.duration[best], rtol=1e-5)
    values = np.array(trace["dimensions"][2]["values"])[kind == 2]
    np.testing.assert_allclose(np.sort(values), np.sort(table.values[best, 2]), rtol=1e-5)
    assert np.all(ends[kind == 0] == NO_DURATION)


def test_the_histogram_and_the_curve_are_shares_of_all_variants():
    table = drawn_study(3000, 2)
    (above,), (below,) = durations_plot(table).rows
    bars = only(below, Bars)
    assert np.sum(bars.end) == pytest.approx(100 * len(table.ranked) / table.variants)
    inside = np.count_nonzero(np.abs(table.duration - bars.place[0]) <= bars.thickness[0] / 2)
    assert bars.end[0] == pytest.approx(100 * inside / table.variants)
    half = np.sort(np.where(np.isnan(table.duration), np.inf, table.duration))[1499]
    marks = only(above, Points)
    assert (marks.x.tolist(), marks.y.tolist()) == ([half], [50.0])  # 85 % can be played at all
    assert only(above, Line).y[-1] == pytest.approx(100 * len(table.ranked) / table.variants)

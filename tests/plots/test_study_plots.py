"""Plots of a study: they hold its numbers, against scipy, and nothing hides anything."""

import numpy as np
import pytest
from found_studies import ELBOW, FORCE, drawn_study, found_study, grid_study, kinds
from legible_figures import check_legible
from scipy.stats import binned_statistic_2d, norm

from mrts.plots import durations_plot, matplotlib_figure, study_map_plot, write_plots
from mrts.plots.plot import HeatMap, Line, Points, one_panel
from mrts.plots.plotly_drawer import plotly_figure
from mrts.plots.study_plots import LIMIT_COLOURS, MOST_CELLS, map_binding, map_remark, study_map, weights
from mrts.plots.study_table import managed

KINDS = kinds()

GROUPED = 0.03
"""Share by which twenty groups of 40 000 variants may be off what infinitely many would tell."""


def only(panel, kind):
    """The item of a kind."""
    (item,) = (item for item in panel.items if isinstance(item, kind))
    return item


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_of_study_has_legible_figures(name, tmp_path):
    table = KINDS[name]
    plots = [durations_plot(table), study_map_plot(table)]
    write_plots(plots, tmp_path / "out")
    names = {path.stem for path in (tmp_path / "out").iterdir()}
    assert names == {"durations", "map" if len(table.knobs) > 1 else "line"}
    for plot in plots:
        check_legible(matplotlib_figure(plot))


def test_the_map_is_the_durations_of_the_best():
    table = grid_study()
    left, right = study_map_plot(table).rows[0]
    heat, without = (item for item in left.items if isinstance(item, HeatMap))
    np.testing.assert_array_equal(heat.z, table.duration.reshape(12, 9).T)
    assert heat.low == np.nanmin(table.duration)
    counts = {without.names[code]: np.count_nonzero(without.z == code) for code in without.found}
    missing = np.count_nonzero(np.isnan(table.duration)) - 27
    assert counts == {"unreachable": 27, "infeasible": missing}
    star = only(left, Points)
    assert [star.x[0], star.y[0]] == table.values[table.ranked[0]].tolist()
    limits, _ = (item for item in right.items if isinstance(item, HeatMap))
    assert list(limits.names) == [FORCE, ELBOW]
    scales = [trace["colorscale"] for panel in (left, right)
              for trace in plotly_figure(one_panel("map", panel))["data"] if "colorscale" in trace]  # fmt: skip
    assert [(scale[0][0], scale[-1][0]) for scale in scales] == [(0, 1)] * 4
    assert np.count_nonzero(limits.z >= 0) == np.count_nonzero(np.isfinite(table.duration))


def test_the_curve_is_a_share_of_all_variants():
    table = drawn_study(3000, 2)
    ((above,),) = durations_plot(table).rows
    half = np.sort(np.where(np.isnan(table.duration), np.inf, table.duration))[1499]
    marks = only(above, Points)
    assert (marks.x.tolist(), marks.y.tolist()) == ([half], [50.0])  # 85 % can be played at all
    curve, playable = (item for item in above.items if isinstance(item, Line))
    assert curve.y[-1] == playable.y[-1] == pytest.approx(100 * len(table.ranked) / table.variants)


def test_limits_are_counted_one_by_one():
    table = found_study(
        np.zeros((4, 1)), np.array([0.4, 0.3, 0.2, np.nan]), limit=[ELBOW, f"{ELBOW}, c² ≥ 0", FORCE, ELBOW]
    )
    assert table.limits(1) == [ELBOW, "c² ≥ 0"]
    assert table.limits(3) == []
    assert table.limit_counts(np.ones(4, dtype=bool)) == [(ELBOW, 2), ("c² ≥ 0", 1), (FORCE, 1)]


def test_reasons_that_differ_by_numbers_are_one():
    reasons = [f"left/wrist_{joint} cannot follow at t = {time:.3g} s" for joint in (1, 2) for time in (0.1, 0.2, 3e-7)]
    table = found_study(np.zeros((7, 1)), np.full(7, np.nan), reason=[*reasons, reasons[0]])
    assert [(outcome, text[:12], count) for outcome, text, count in table.reasons()] == [
        ("infeasible", "left/wrist_1", 4), ("infeasible", "left/wrist_2", 3)
    ]  # fmt: skip


def test_the_ranking_is_by_duration_then_number():
    table = found_study(np.zeros((6, 1)), np.array([0.5, 0.3, np.nan, 0.3, 0.9, 0.4]))
    assert table.ranked.tolist() == [1, 3, 5, 0, 4]
    assert table.admitted.tolist() == [True, True, False, True, True, True]


def test_cells_of_drawn_points_show_the_best_of_theirs():
    table = drawn_study(2000, 3)
    drawn = study_map(table)
    assert 2 < drawn.best.shape[0] == drawn.best.shape[1] <= MOST_CELLS
    assert "other number; knob 0 and knob 1" in map_remark(table, drawn)
    has = np.isfinite(table.duration)
    points = np.delete(table.values, 2, axis=1)
    least = binned_statistic_2d(*points[has].T, table.duration[has], "min", drawn.edges).statistic.T
    np.testing.assert_array_equal(drawn.durations(table), np.where(np.isnan(least), np.nan, least))
    count = binned_statistic_2d(*points.T, None, "count", drawn.edges).statistic.T
    np.testing.assert_array_equal(drawn.outcome >= 0, (count > 0) & (drawn.best < 0))


@pytest.mark.parametrize("share", [0.3, 0.95])
def test_a_number_explains_what_the_normal_distribution_says(share):
    """Ranks of a x + b z, all normal: x explains (6/π) arcsin(a²/2), by the arcsine law of two correlated ones."""
    rng = np.random.default_rng(3)
    values = rng.normal(size=(40_000, 3))
    spread = share * values[:, 0] + np.sqrt(1 - share**2) * values[:, 1]
    found = weights(found_study(values, norm.cdf(spread) + 1))
    for knob, factor in ((0, share), (1, np.sqrt(1 - share**2)), (2, 0.0)):
        assert found[knob] == pytest.approx([6 / np.pi * np.arcsin(factor**2 / 2), 0.0], abs=GROUPED)
    duration = np.where(values[:, 2] > 0, np.nan, 1.0)
    assert weights(found_study(values, duration))[:, 1] == pytest.approx([0.0, 0.0, 1.0], abs=GROUPED)


@pytest.mark.parametrize("share", [1, 84, 86, 100])
def test_the_share_that_manages_a_duration_is_a_quantile_of_all(share):
    table = drawn_study(997, 2)
    all_of_them = np.where(np.isnan(table.duration), np.inf, table.duration)
    expected = np.quantile(all_of_them, share / 100, method="inverted_cdf")
    assert (managed(table, share) or np.inf) == expected


def test_limits_beyond_the_colours_share_the_last():
    table = KINDS["eleven limits"]
    drawn = study_map(table)
    names, codes = map_binding(table, drawn)
    assert len(names) == len(LIMIT_COLOURS)
    assert names[-1] == "5 other limits"
    for place, row in np.ndenumerate(drawn.best):
        if row >= 0:
            (name,), shown = table.limits(row), names[codes[place]]
            assert shown == name or (shown == names[-1] and name not in names)
    assert np.all((codes < 0) == (drawn.best < 0))

"""Plots of a study: they hold its numbers, against scipy, and nothing hides anything."""

import numpy as np
import pytest
from found_studies import ELBOW, FORCE, drawn_study, found_study, grid_study, kinds
from legible_figures import check_legible
from scipy.stats import binned_statistic

from mrts.plots import durations_plot, matplotlib_figure, numbers_plot, write_plots
from mrts.plots.plot import Line, Points
from mrts.plots.study_plots import managed

KINDS = kinds()


def only(panel, kind):
    """The item of a kind."""
    (item,) = (item for item in panel.items if isinstance(item, kind))
    return item


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_of_study_has_legible_figures(name, tmp_path):
    table = KINDS[name]
    plots = [durations_plot(table), numbers_plot(table)]
    write_plots(plots, tmp_path / "out")
    names = {path.stem for path in (tmp_path / "out").iterdir()}
    assert names == {"durations", "numbers"}
    for plot in plots:
        check_legible(matplotlib_figure(plot))


def test_each_number_has_the_best_of_all_others():
    table = grid_study()
    ((left, right),) = numbers_plot(table).rows
    durations = table.duration.reshape(12, 9)
    np.testing.assert_array_equal(only(left, Line).y[3:], np.nanmin(durations[3:], axis=1))
    assert np.all(np.isnan(only(left, Line).y[:3]))  # unreachable
    np.testing.assert_array_equal(only(right, Line).y, np.nanmin(durations, axis=0))
    star, (x, y) = only(left, Points), table.values[table.ranked[0]]
    assert [star.x[0], star.y[0]] == [x, np.nanmin(durations)]
    assert [text.endswith(FORCE) for text in only(left, Line).texts] == (only(left, Line).x >= 0.5).tolist()
    assert only(right, Points).x == [y]


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


def test_points_of_drawn_variants_show_the_best_of_theirs():
    table = drawn_study(2000, 3)
    has, values = np.isfinite(table.duration), table.values[:, 0]
    line = only(numbers_plot(table).rows[0][0], Line)
    edges = np.linspace(np.min(values), np.max(values), len(line.x) + 1)
    np.testing.assert_array_equal(line.y, binned_statistic(values[has], table.duration[has], "min", edges).statistic)


@pytest.mark.parametrize("share", [1, 84, 86, 100])
def test_the_share_that_manages_a_duration_is_a_quantile_of_all(share):
    table = drawn_study(997, 2)
    all_of_them = np.where(np.isnan(table.duration), np.inf, table.duration)
    expected = np.quantile(all_of_them, share / 100, method="inverted_cdf")
    assert (managed(table, share) or np.inf) == expected

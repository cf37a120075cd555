"""What pictures take from a study: the ranking, maps, how much numbers matter, words."""

import numpy as np
import pandas as pd
import pytest
from found_studies import ELBOW, FORCE, drawn_study, found_study, grid_study, kinds
from scipy.stats import binned_statistic_2d, norm

import mrts
from mrts.plots.labels import row_label
from mrts.plots.study_map import MOST_CELLS, OUTERMOST, ends_reached, map_binding, map_remark, study_map, weights
from mrts.plots.study_plots import MOST_LINES, NO_DURATION, parallel_figure
from mrts.plots.study_table import OUTCOMES
from mrts.plots.study_words import best_rows, managed, managed_texts, next_steps, outcome_text, percent

KINDS = kinds()

GROUPED = 0.03
"""Share by which twenty groups of 40 000 variants may be off what infinitely many would tell."""


def frame(table):
    """The same numbers for pandas."""
    found = pd.DataFrame(table.values, columns=[knob.path for knob in table.knobs])
    return found.assign(duration=table.duration, outcome=[table.outcome.names[code] for code in table.outcome.codes])


def test_texts_lose_their_moment_value_and_load():
    limits = [f"{ELBOW} at t = 0.1 s with mass 3 kg", "right/elbow torque (upper, 81.5 N m), c² ≥ 0", FORCE, ELBOW]
    table = found_study(np.zeros((4, 1)), np.array([0.4, 0.3, 0.2, np.nan]), limit=limits)
    names = [table.limit.names[code] if code >= 0 else None for code in table.limit.codes]
    assert names == ["right/elbow ↑", "right/elbow ↑, c² ≥ 0", "left/fx ↓", None]
    assert table.limits(1) == ["right/elbow ↑", "c² ≥ 0"]
    assert table.limits(3) == []
    assert table.limit_counts(np.ones(4, dtype=bool)) == [("right/elbow ↑", 2), ("c² ≥ 0", 1), ("left/fx ↓", 1)]


def test_limits_are_named_as_in_the_pictures_of_a_result(planar_cell, lift):
    for cell in (planar_cell, planar_cell.with_mass(3.0)):
        end = mrts.scale(cell, lift).range.upper
        table = found_study(np.zeros((1, 1)), np.array([0.3]), limit=", ".join(map(str, end.rows)))
        assert table.limits(0) == [row_label(row) for row in end.rows]


def test_reasons_that_differ_by_numbers_are_one():
    reasons = [f"left/wrist_{joint} cannot follow at t = {time:.3g} s" for joint in (1, 2) for time in (0.1, 0.2, 3e-7)]
    table = found_study(np.zeros((7, 1)), np.full(7, np.nan), reason=[*reasons, reasons[0]])
    assert table.reasons() == [("infeasible", reasons[0], 4), ("infeasible", reasons[3], 3)]


def test_the_ranking_is_that_of_pandas():
    table = found_study(np.zeros((6, 1)), np.array([0.5, 0.3, np.nan, 0.3, 0.9, 0.4]))
    assert table.ranked.tolist() == frame(table).dropna().sort_values("duration", kind="stable").index.tolist()
    assert table.admitted.tolist() == [True, True, False, True, True, True]


@pytest.mark.parametrize("name", ["grid", "unbounded", "all alike"])
def test_cells_of_a_grid_are_its_variants(name):
    table = KINDS[name]
    drawn = study_map(table)
    assert drawn.exact
    assert map_remark(table, drawn) == ""
    data = frame(table)
    for place, row in np.ndenumerate(drawn.best):
        values = [cells.middles[at] for cells, at in zip(drawn.axes, reversed(place), strict=True)]
        edges = [(cells.edges[at], cells.edges[at + 1]) for cells, at in zip(drawn.axes, reversed(place), strict=True)]
        inside = np.all([(low < data[knob.path]) & (data[knob.path] < high)
                         for knob, (low, high) in zip(table.knobs, edges, strict=True)], axis=0)  # fmt: skip
        own = data[inside]
        assert len(own) == 1
        assert np.allclose(own.iloc[0, :2].astype(float), values, atol=1e-9)
        if np.isfinite(own.duration.iloc[0]):
            assert row == own.index[0]
        else:
            assert (row, list(OUTCOMES)[drawn.outcome[place]]) == (-1, own.outcome.iloc[0])


def test_cells_of_drawn_points_show_the_best_of_theirs():
    table = drawn_study(2000, 3)
    drawn = study_map(table, ("knob 1", "knob 2"))
    x, y = drawn.axes
    assert 2 < x.count == y.count <= MOST_CELLS
    assert "other number; knob 1 and knob 2" in map_remark(table, drawn)
    has = np.isfinite(table.duration)
    points = np.delete(table.values, 0, axis=1)
    least = binned_statistic_2d(*points[has].T, table.duration[has], "min", [x.edges, y.edges]).statistic.T
    np.testing.assert_array_equal(drawn.of_best(table.duration), np.where(np.isnan(least), np.nan, least))
    count = binned_statistic_2d(*points.T, None, "count", [x.edges, y.edges]).statistic.T
    np.testing.assert_array_equal(drawn.outcome >= 0, (count > 0) & (drawn.best < 0))
    for wrong in (("knob 9",), ("knob 1", "knob 1"), ("knob 0", "knob 1", "knob 2")):
        with pytest.raises(mrts.InputError, match="one or two of what the study varies: knob 0, knob 1, knob 2"):
            study_map(table, wrong)


def test_the_limit_of_every_cell_is_that_of_its_best():
    table = KINDS["eleven limits"]
    drawn = study_map(table)
    names, codes = map_binding(table, drawn)
    assert names[-1] == "5 other limits"
    for place, row in np.ndenumerate(drawn.best):
        if row >= 0:
            name, shown = table.limit.names[table.limit.codes[row]], names[codes[place]]
            assert shown == name or (shown == names[-1] and name not in names)
    assert np.all((codes < 0) == (drawn.best < 0))


@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
def test_a_number_explains_what_the_normal_distribution_says(share):
    """Ranks of a x + b z, all normal: x explains (6/π) arcsin(a²/2), by the arcsine law of two correlated ones."""
    rng = np.random.default_rng(3)
    values = rng.normal(size=(40_000, 3))
    spread = share * values[:, 0] + np.sqrt(1 - share**2) * values[:, 1]
    found = {weight.knob: weight for weight in weights(found_study(values, norm.cdf(spread) + 1))}
    for knob, factor in ((0, share), (1, np.sqrt(1 - share**2)), (2, 0.0)):
        assert found[knob].duration == pytest.approx(6 / np.pi * np.arcsin(factor**2 / 2), abs=GROUPED)
        assert found[knob].playable == 0
    duration = np.where(values[:, 2] > 0, np.nan, 1.0)
    assert weights(found_study(values, duration))[0].playable == pytest.approx(1.0, abs=GROUPED)
    assert weights(found_study(values, duration))[0].knob == 2


def test_a_choice_of_a_long_grid_tells_the_same():
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(0, 1, 500), np.linspace(0, 1, 400)))
    found = weights(found_study(np.stack([x, y], axis=1), 0.3 + 0.01 * x + y))
    assert [weight.knob for weight in found] == [1, 0]
    assert found[0].duration == pytest.approx(1, abs=GROUPED)
    assert found[1].duration == pytest.approx(0, abs=GROUPED)


@pytest.mark.parametrize("share", [1, 50, 84, 86, 100])
def test_the_share_that_manages_a_duration_is_a_quantile_of_all(share):
    table = drawn_study(997, 2)
    all_of_them = np.where(np.isnan(table.duration), np.inf, table.duration)
    expected = np.quantile(all_of_them, share / 100, method="inverted_cdf")
    assert (managed(table, share) or np.inf) == expected


def test_words_say_how_many_and_how_fast():
    table = grid_study(planned=400)
    text = outcome_text(table)
    counts = frame(table).outcome.value_counts()
    assert text.startswith(f"{counts['feasible']} of 108 variants solved so far, of 400 may be played")
    assert f"{counts['unreachable']} unreachable, {counts['infeasible']} infeasible" in text
    assert managed_texts(table)[-1].startswith("no duration suits")
    assert managed_texts(KINDS["all alike"]) == [
        f"{share} % of variants finish within 0.4 s" for share in (50, 90, 95, 99)
    ]
    assert [percent(*pair) for pair in ((0, 5), (1, 10**6), (999_999, 10**6), (5, 5), (1, 3))] == [
        "0 %", "0.0001 %", "99.9 %", "100 %", "33.3 %"
    ]  # fmt: skip


def test_the_best_table_holds_the_numbers_of_the_best():
    table = grid_study()
    head, rows = best_rows(table, 3)
    by_title = dict(zip(head, zip(*rows, strict=True), strict=True))
    assert by_title["variant"] == ("from … to", *(str(row) for row in table.ranked[:3]))
    assert by_title["duration [s]"][1:] == tuple(f"{value:.4g}" for value in np.sort(table.duration)[:3])
    assert by_title["knob 1 [m]"] == ("2 … 3", "2 (end)", "2 (end)", "2 (end)")
    assert by_title["limited by"][1] == "left/fx ↓"


def test_the_next_step_is_the_one_that_the_numbers_ask_for():
    table = grid_study()
    steps, without = "\n".join(next_steps(table)), np.count_nonzero(np.isnan(table.duration))
    assert "Of the best, knob 1 is at the lower end of what was tried (2 m): try further" in steps
    assert "knob 0 is at the" not in steps
    assert "knob 1 matters most" in steps
    assert f"27 of the {without} variants that cannot be played are unreachable" in steps
    assert "left/fx ↓ limits" in steps
    inside = np.random.default_rng(1).uniform(0, 1, (500, 3))
    calm = "\n".join(next_steps(found_study(inside, 0.5 + (inside[:, 0] - 0.5) ** 2)))
    assert "try further" not in calm
    assert "knob 1, knob 2 by themselves hardly do anything" in calm
    assert "cannot be played" not in calm
    hopeless = next_steps(KINDS["nothing can be played"])
    assert hopeless == [
        "30 of the 30 variants that cannot be played are infeasible, such as: left/elbow and right/fx conflict."
    ]


def test_an_end_is_one_of_what_was_tried():
    values = np.linspace(0, 1, 201)[:, None]
    table = found_study(values, 1 + values[:, 0])
    ends = [bool(ends_reached(table, row)) for row in range(201)]
    outermost = (values[:, 0] <= OUTERMOST) | (values[:, 0] >= 1 - OUTERMOST)
    assert ends == outermost.tolist()


@pytest.mark.parametrize("name", KINDS)
def test_lines_stay_within_their_axes(name):
    table = KINDS[name]
    figure = parallel_figure(table)
    (trace,) = figure["data"]
    kinds, *_ = counts = np.bincount(trace["line"]["color"], minlength=3)
    assert max(counts) <= MOST_LINES
    assert ("an even choice" in figure["remark"]) == (sum(counts) < table.variants)
    assert kinds == min(MOST_LINES, table.variants - len(table.ranked))
    for axis in trace["dimensions"]:
        low, high = axis.get("range", (-np.inf, np.inf))
        assert low - 1e-5 <= min(axis["values"]) <= max(axis["values"]) <= high + 1e-5
    assert sum(np.array(trace["dimensions"][-1]["values"]) == NO_DURATION) == kinds


def test_a_long_study_is_shown_by_few_lines_and_cells():
    table = drawn_study(200_000, 4)
    drawn = study_map(table)
    assert drawn.best.size <= MOST_CELLS**2
    assert table.ranked[0] in drawn.best
    assert parallel_figure(table)["remark"] == "an even choice of 600 of 200000 variants"


def test_limits_have_the_names_of_other_plots():
    texts = "right/wrist velocity (3.14 rad/s), right/elbow torque (upper, 80 N m), left/pad slips: friction 100 % used"
    found = found_study(np.array([[0.5], [0.6]]), np.array([0.4, 0.5]), limit=texts)
    assert found.limits(0) == ["right/wrist velocity", "right/elbow ↑", "left/pad slips"]

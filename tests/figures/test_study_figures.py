"""Figures of a study: they show its numbers, and nothing hides anything."""

import numpy as np
import pytest
from found_studies import drawn_study, grid_study, kinds
from legible_figures import check_legible
from matplotlib.collections import LineCollection, PolyCollection, QuadMesh
from matplotlib.figure import Figure

from mrts.drawing.study_lines import NO_DURATION
from mrts.drawing.study_map import LIMIT_COLOURS
from mrts.figures import (
    best_variants_figure,
    draw_durations,
    draw_limit_map,
    draw_managed,
    draw_parallel_coordinates,
    draw_study_line,
    draw_study_map,
    parallel_axes,
    study_map,
    write_study_figures,
)
from mrts.figures.study_figures import study_figures
from mrts.figures.style import in_lines

KINDS = kinds()


def legend_of(axes):
    """Labels of a legend."""
    return [text.get_text().strip() for text in axes.get_legend().get_texts()]


def cells_of(figure):
    """Texts of a table's cells, by row and column."""
    return {place: cell.get_text().get_text() for place, cell in figure.axes[0].tables[0].get_celld().items()}


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_of_study_has_legible_figures(name, tmp_path):
    table = KINDS[name]
    write_study_figures(table, tmp_path / "out")
    names = {path.stem for path in (tmp_path / "out").iterdir()}
    figures = study_figures(table)
    assert names == set(figures)
    assert {"map", "line"} & names
    assert ("parallel_coordinates" in names) == (len(table.knobs) > 2)
    assert ("best_variants" in names) == bool(len(table.ranked))
    for figure in figures.values():
        check_legible(figure)


def test_the_map_is_the_durations_of_the_best():
    table = grid_study()
    drawn = study_map(table)
    left, right = Figure().subplots(1, 2)
    draw_study_map(left, table, drawn)
    draw_limit_map(right, table, drawn)
    mesh = next(each for each in left.collections if isinstance(each, QuadMesh))
    np.testing.assert_array_equal(mesh.get_array().filled(np.nan), drawn.of_best(table.duration))
    assert mesh.norm.vmin == np.nanmin(table.duration)
    hatched = {each.get_label(): len(each.get_paths()) for each in left.collections if isinstance(each, PolyCollection)}
    assert hatched == {"unreachable": 27, "infeasible": np.count_nonzero(np.isnan(table.duration)) - 27}
    star = next(line for line in left.lines if line.get_marker() == "*")
    assert star.get_xydata()[0].tolist() == table.values[table.ranked[0]].tolist()
    assert any(line.get_paths() for line in left.collections if "Contour" in type(line).__name__)
    limits = [each for each in right.collections if each.get_label() in table.limit.names]
    assert sum(len(each.get_paths()) for each in limits) == np.count_nonzero(np.isfinite(table.duration))
    assert legend_of(right) == ["left/fx ↓", "right/elbow ↑", "infeasible",
                                "unreachable", "the best"]  # fmt: skip
    assert len({patch.get_facecolor() for patch in right.get_legend().get_patches()[:2]}) == 2


def test_limits_beyond_the_colours_share_the_last():
    table = KINDS["eleven limits"]
    axes = Figure().subplots()
    draw_limit_map(axes, table, study_map(table))
    assert legend_of(axes)[: len(LIMIT_COLOURS)][-1] == "5 other limits"


def test_the_line_has_what_binds_as_bands():
    table = KINDS["one number"]
    axes = Figure().subplots()
    drawn = study_map(table)
    draw_study_line(axes, table, drawn)
    curve = axes.lines[0]
    order = np.argsort(table.values[:, 0])
    np.testing.assert_allclose(curve.get_ydata(), table.duration[order])
    bands = [patch for patch in axes.patches if patch.get_label() == "infeasible"]
    ends = bands[0].get_extents().transformed(axes.transData.inverted())
    missing = table.values[np.isnan(table.duration), 0]
    assert ends.x0 <= np.min(missing)
    assert ends.x1 >= np.max(missing)


def test_lines_of_the_best_end_at_their_durations():
    table = drawn_study(600, 4)
    axes = Figure().subplots()
    drawn = parallel_axes(table)
    draw_parallel_coordinates(axes, table, drawn)
    groups = {each.get_label(): each for each in axes.collections if isinstance(each, LineCollection)}
    best = np.array([path.vertices for path in groups["the best 5 %"].get_paths()])
    assert best.shape == (len(drawn.best), 5, 2)
    span = drawn.high - drawn.low
    durations = drawn.low[-1] + best[:, -1, 1] * span[-1]
    np.testing.assert_allclose(np.sort(durations), np.sort(table.duration[drawn.best]))
    values = drawn.low[2] + best[:, 2, 1] * span[2]
    np.testing.assert_allclose(np.sort(values), np.sort(table.values[drawn.best, 2]))
    without = np.array([path.vertices for path in groups["cannot be played"].get_paths()])
    assert np.all(without[:, -1, 1] == NO_DURATION)


def test_the_histogram_and_the_curve_are_shares_of_all_variants():
    table = drawn_study(3000, 2)
    above, below = Figure().subplots(2)
    draw_managed(above, table)
    draw_durations(below, table)
    shown = sum(bar.get_height() for bar in below.patches)
    inside = np.count_nonzero(table.duration <= below.patches[-1].get_x() + below.patches[-1].get_width())
    assert shown == pytest.approx(100 * inside / table.variants)
    assert inside > 0.98 * len(table.ranked)
    said = {text.get_text() for text in above.texts}
    half = np.sort(np.where(np.isnan(table.duration), np.inf, table.duration))[1499]
    assert said == {f"50 %: {half:.4g} s"}  # 85 % can be played at all
    top = above.lines[0].get_ydata()[-1]
    assert top == pytest.approx(100 * len(table.ranked) / table.variants)


def test_the_table_names_the_best():
    table = grid_study()
    cells = cells_of(best_variants_figure(table))
    for column, row in enumerate(table.ranked[:5], 2):
        assert cells[0, column] == str(table.variant[row])
        assert cells[1, column] == f"{table.duration[row]:.4g}"


@pytest.mark.parametrize("name", ["four numbers", "many numbers", "one variant"])
def test_words_of_the_table_stay_in_their_cells(name):
    figure = best_variants_figure(KINDS[name])
    figure.draw_without_rendering()
    for cell in figure.axes[0].tables[0].get_celld().values():
        inside, text = cell.get_window_extent(), cell.get_text().get_window_extent()
        assert text.x1 <= inside.x1 + 1, cell.get_text()
        assert text.height <= inside.height + 1, cell.get_text()


def test_a_long_study_says_that_it_is_shown_in_part():
    table = drawn_study(100_000, 4)
    figures = study_figures(table)
    assert "an even choice of 600 of 100000 variants" in figures["parallel_coordinates"].get_suptitle()
    assert "each of 60 × 60 cells shows the best of its variants" in figures["map"].get_suptitle()


def test_names_break_after_dots_and_slashes_and_numbers_do_not():
    assert in_lines("robots.left.base.xyz[1] [m]", 15) == "robots.left.\nbase.xyz[1] [m]"
    assert in_lines("right/wrist_2_turn velocity ↑, left/fx ↓ and 3 more", 16) == (
        "right/\nwrist_2_turn\nvelocity ↑,\nleft/fx ↓ and 3\nmore"
    )
    assert in_lines("right/wrist_2_turn_joint ↑", 16) == "right/\nwrist_2_turn_joint ↑"
    assert in_lines("0.3468 … 0.5974", 7) == "0.3468\n…\n0.5974"

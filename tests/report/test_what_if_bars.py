"""What changes to a cell would do, in the report: bars and words."""

from dataclasses import replace

import pytest
from conftest import DATA

import mrts
from mrts.plots.plot import Bars
from mrts.plots.what_if_plot import MOST_BARS, what_if_plot
from mrts.report import report_html
from mrts.report.tables import changes_in_words, changes_left_out


@pytest.mark.quick
def test_bars_are_the_numbers_of_the_changes(planar_cell, lift):
    result = mrts.scale(planar_cell, lift)
    found = result.what_if()
    panel = what_if_plot(found).rows[0][0]
    up, down = (item for item in panel.items if isinstance(item, Bars))
    names = panel.y.names
    for bars, sign in ((up, "+"), (down, "-")):
        by_name = {names[round(row)]: end for row, end in zip(bars.place, bars.end, strict=True)}
        for one in found.changes:
            if one.change.size.startswith(sign) and one.matters:
                assert by_name[one.change.what] == pytest.approx(100 * one.c2_change, rel=1e-5), one
        assert len(bars.texts) == len(bars.end)
    largest = [max(abs(end) for of in (up, down) for row, end in zip(of.place, of.end, strict=True) if round(row) == at)
               for at in range(len(names))]  # fmt: skip
    assert largest == sorted(largest, reverse=True)
    assert set(names) == {one.change.what for one in found.changes if one.matters}
    text = report_html(replace(result, changes=found))
    assert "What a change does to c²⁺" in text
    assert "Nothing else matters: 2 torque limits may be changed as much, one at a time, and the speed stays." in text
    assert "What a change does" not in report_html(result)


@pytest.mark.quick
def test_what_bars_cannot_show_is_listed(planar_cell, lift):
    heavy = mrts.scale(planar_cell.with_mass(13.0), lift)
    found = heavy.what_if(share=0.3)
    assert what_if_plot(found) is None  # nothing to be a share of
    ((title, changes),) = changes_in_words(found)
    assert title == "With these it can be played:"
    assert any(change.startswith("mass -30 %: feasible, c² ") for change in changes)
    *_, (title, changes) = changes_in_words(mrts.scale(planar_cell.with_mass(7.0), lift).what_if(share=0.8, shift=0.9))
    assert title == "With these it cannot be played:"
    assert any(change.startswith("mass +80 %: infeasible: ") for change in changes)


@pytest.mark.quick
def test_a_timing_has_bars_of_its_duration(planar_cell, lift):
    found = mrts.retime(planar_cell, lift).what_if()
    panel = what_if_plot(found).rows[0][0]
    down = [item for item in panel.items if isinstance(item, Bars)][1]
    shares = {panel.y.names[round(row)]: end for row, end in zip(down.place, down.end, strict=True)}
    (slower,) = [one for one in found.changes if str(one.change) == "left/shoulder -10 %"]
    expected = 100 * (slower.after.duration / slower.before.duration - 1)
    assert shares["left/shoulder"] == pytest.approx(expected, rel=1e-5)
    assert expected > 1


def test_more_bars_than_fit_are_counted(dual_ur5):
    motion = mrts.load_motion(DATA.parent / "dual_ur5" / "lift_and_turn.yaml")
    found = mrts.retime(dual_ur5, motion).what_if()
    assert len(what_if_plot(found).rows[0][0].y.names) == MOST_BARS
    count = len({one.change.what for one in found.changes if one.matters}) - MOST_BARS
    assert count > 0
    assert changes_left_out(found)[0] == f"{count} more do less than these"

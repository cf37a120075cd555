"""How far a sweep is, from rows as they come."""

import pyarrow as pa
import pytest

from mrts.sweeps.sweep_progress import Tally

ROWS = [{"variant": 0, "status": "unreachable", "duration": None},
        {"variant": 1, "status": "feasible", "duration": 0.5},
        {"variant": 2, "status": "feasible", "duration": 0.4},
        {"variant": 3, "status": "feasible", "duration": 0.4}]  # fmt: skip


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 2, 1, 0), (3, 0, 2, 1)])
def test_the_best_of_equals_has_the_lower_number_in_whatever_order_they_come(order):
    tally = Tally(len(ROWS))
    for row in order:
        tally.add(pa.Table.from_pylist([ROWS[row]], schema=pa.Table.from_pylist(ROWS).schema))
    found = tally.progress()
    assert (found.done, found.best, found.best_variant) == (4, 0.4, 2)


def test_where_nothing_can_be_played_there_is_no_best():
    tally = Tally(1)
    tally.add(pa.Table.from_pylist(ROWS[:1], schema=pa.Table.from_pylist(ROWS).schema))
    assert tally.progress().best is None

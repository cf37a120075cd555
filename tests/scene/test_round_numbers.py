"""Round numbers below given ones."""

import numpy as np
import pytest

from mrts.scene.scene import round_down


@pytest.mark.quick
@pytest.mark.parametrize("exact", [1e-3, 0.1, 1.0, 2.0, 50.0, 1000.0])
def test_a_round_number_is_itself_whatever_its_last_digit(exact):
    for value in (exact, np.nextafter(exact, 0), np.nextafter(exact, np.inf)):
        assert round_down(value) == pytest.approx(exact)


@pytest.mark.quick
def test_the_largest_below():
    assert round_down(4.9) == 2
    assert round_down(0.0199) == pytest.approx(0.01)
    assert round_down(999.0) == 500

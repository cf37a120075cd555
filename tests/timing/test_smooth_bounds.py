"""The search for a smooth timing ends: what it keeps at its bounds, and Ctrl-C inside a long program."""

import pytest
from conftest import DATA
from random_motors import equipped
from shipped_cells import sampled, shipped_motion

import mrts


@pytest.fixture(scope="module")
def rounded():
    """A timing whose samples are too close for their rounding once limits of jerk ask for more nodes."""
    cell = equipped(mrts.load_cell(DATA.parent / "squeeze" / "cell.yaml"), jerk=950.0)
    return mrts.retime(cell, sampled(shipped_motion("squeeze", samples=58, duration=2.4)), rates=11.5, between=1e-5)


def test_the_timing_with_the_least_excess_is_kept_and_said(rounded):
    assert rounded.status is mrts.RetimingStatus.LOCALLY_AT_SAMPLES
    assert rounded.smooth.steps <= 40
    assert rounded.motion.samples <= 600
    assert 1e-5 < rounded.excess.share < 1e-4
    (told,) = [warning for warning in rounded.to_json()["warnings"] if warning["code"] == "search-stopped"]
    assert f"{rounded.motion.samples} nodes" in told["text"]

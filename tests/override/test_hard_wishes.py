"""Wishes that try a speed override: random, the worst that a search finds, other loads, and what is no wish at all."""

import numpy as np
import pytest
from shipped_cells import DATA

import mrts

BETWEEN = 2e-4
"""Share of a limit by which a tick may pass it: twice what tables are made to, for places where nobody looked."""


def shipped_motion_of(name):
    """A shipped cell and its motion."""
    folder = DATA / name
    motion = next(path for path in (folder / "lift.yaml", folder / "lift_and_turn.yaml") if path.exists())
    return mrts.load_cell(folder / "cell.yaml"), mrts.load_motion(motion)


@pytest.fixture(scope="module")
def slow_lift():
    """A plan far below what limits allow."""
    return mrts.scale(*shipped_motion_of("planar_dual_arm"), 0.3)


@pytest.mark.quick
def test_a_largest_speed_that_is_the_same_everywhere_is_a_speed(slow_lift):
    override = mrts.SpeedOverride(slow_lift, fastest=1.2)
    assert np.ptp(override.nodes["most"]) == 0
    states = override.play(np.random.default_rng(0).uniform(0, 2, 4000))
    assert np.max(states["speed"]) == pytest.approx(1.2)
    assert np.max(override.excess(states)) <= BETWEEN


@pytest.mark.quick
def test_at_rest_at_an_end_nothing_changes_until_it_is_left(slow_lift):
    override = mrts.SpeedOverride(slow_lift, backwards=True)
    back = override.play(np.full(400, -1.0), state=override.start(0.02))
    arrived = int(np.argmax(back["finished"]))
    assert np.all(back["finished"][arrived:] == 1)
    assert not np.any(np.ptp(back["torque"][arrived:], axis=0))
    assert not np.any(back["active"][arrived:])
    away = override.play(np.full(3000, 1.0), state=override.start(0.02))
    assert np.max(away["time"]) == override.duration


@pytest.mark.quick
def test_what_is_no_state_or_time_of_this_override_is_refused(slow_lift):
    override = mrts.SpeedOverride(slow_lift)
    longer = mrts.SpeedOverride(mrts.scale(*shipped_motion_of("dual_ur5"), 0.3))
    here, elsewhere = override.start(0.1), longer.start(0.3)
    wrong = {
        "state": [
            lambda: override.step(elsewhere, 1.0),
            lambda: override.play(np.ones(2), state=elsewhere),
            lambda: override.stop_time(elsewhere),
            lambda: override.speed_for_stop(elsewhere, 1.0),
            lambda: override.step(None, 1.0),
        ],
        "dt": [lambda: override.stop_time(here, 0.0), lambda: override.speed_for_stop(here, 1.0, np.nan)],
        "seconds": [lambda: override.speed_for_stop(here, np.nan), lambda: override.speed_for_stop(here, -1.0)],
        "within": [lambda: override.resume(here.q, "near"), lambda: override.resume(here.q, np.nan)],
    }
    for key, calls in wrong.items():
        for call in calls:
            with pytest.raises(mrts.InputError) as refused:
                call()
            assert refused.value.key == key or str(refused.value).startswith(key)

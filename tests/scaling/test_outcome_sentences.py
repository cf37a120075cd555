"""What a result says in one sentence, for every outcome: the range, what it means in seconds, and what sets it."""

import re
from dataclasses import replace

import numpy as np
import pytest
from shown_results import braking_only, result_of

import mrts
from mrts.base.interval_text import interval_text
from mrts.output.summary_lines import scaling_lines
from mrts.plots.card import answer_card
from mrts.scaling.result import _speed_advice

pytestmark = pytest.mark.quick

AT_REST = {"duration": 1.0, "samples": 11, "profile": "quintic", "start": {"xyz": [1.25, 1, 0]}}


def with_vertical_force(cell, least, largest):
    """Strong arms whose hands must press upward by some force."""
    robots = tuple(
        replace(
            robot,
            torque_lower=robot.torque_lower * 100,
            torque_upper=robot.torque_upper * 100,
            wrench_lower=np.array([-np.inf, least, -np.inf]),
            wrench_upper=np.array([np.inf, largest, np.inf]),
        )
        for robot in cell.robots
    )
    return replace(cell, robots=robots)


@pytest.fixture(scope="module")
def start_of_lowering():
    """Downward, speeding up: fast it weighs little, slow it weighs its 4.9 N; 0.095 s."""
    low = mrts.sample_motion(
        mrts.MotionDescription.model_validate(
            {"duration": 0.5, "profile": "sinusoid", "start": {"xyz": [1.25, 1.5, 0]}, "end": {"xyz": [1.25, 1.0, 0]}}
        )
    )
    fields = (low.time, low.position, low.rotation, low.twist, low.acceleration)
    return mrts.ObjectMotion(*(field[:20] for field in fields))


@pytest.mark.parametrize(
    ("largest", "says"),
    [
        (2.2, "you must play it 0.35 to 0.767 × as fast as given: 0.2714 to 0.1239 s instead of 0.095 s"),
        (2.45, "you must play it at most 0.767 × as fast as given: 0.1239 s instead of 0.095 s"),
    ],
)
def test_no_slower_than_what_can_be_held(planar_cell, start_of_lowering, largest, says):
    text = mrts.scale(with_vertical_force(planar_cell, 1.0, largest), start_of_lowering).summary()
    assert says in text
    assert "limited at t = 0 s by" in text or "limited above at t = 0 s by" in text
    assert ("below at t = 0.095 s by" in text) == (largest < 2.45)


def test_a_range_about_the_motion_as_given_needs_no_must(planar_cell, start_of_lowering):
    slower = replace(start_of_lowering, time=start_of_lowering.time * 2, twist=start_of_lowering.twist / 2,
                     acceleration=start_of_lowering.acceleration / 4)  # fmt: skip
    text = mrts.scale(with_vertical_force(planar_cell, 1.0, 2.2), slower).summary()
    assert "c² ∈ [0.49, 2.351]: you may play it 0.7 to 1.53 × as fast as given: 0.2714 to 0.1239 s" in text


def test_only_rest(planar_cell, start_of_lowering):
    with pytest.raises(mrts.SelectionError) as caught:
        mrts.scale(with_vertical_force(planar_cell, 2.45, 3.0), start_of_lowering)
    text = caught.value.result.summary()
    assert text.startswith("c² ∈ [0, 0]: the cell can hold the object still at every sample, but not move it along")


def test_nothing_that_limits_the_speed(planar_cell):
    description = mrts.MotionDescription.model_validate(AT_REST | {"end": AT_REST["start"]})
    text = mrts.scale(planar_cell, mrts.sample_motion(description)).summary()
    assert text == "c² ∈ [0, ∞): No limit depends on the speed at the samples: you may play it as fast as you like."


def test_no_common_speed(planar_cell, start_of_lowering):
    cell = with_vertical_force(planar_cell, 1.0, 3.0).with_variation(mass=(0.45, 2.0))
    text = mrts.scale(cell, start_of_lowering).summary()
    assert text.startswith("for every load of the box (mass 0.225 … 1 kg): empty: c² must be at least 0.4655")
    assert "but at most 0.0923" in text
    assert "Change the velocity profile" in text


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        (0.0, 3.0618, "[0, 3.062] N m"),
        (0.0, np.inf, "[0, ∞) N m"),
        (-np.inf, 2.5, "(−∞, 2.5] N m"),
        (-np.inf, np.inf, "unbounded"),
        (5.0, 3.0, "empty (at least 5, but at most 3)"),
        (2.0, 2.0, "[2, 2] N m"),
    ],
)
def test_an_interval(low, high, text):
    assert interval_text(low, high, "N m") == text


def test_no_crossed_and_no_infinite_interval_is_shown(planar_cell, lift, tmp_path):
    kinds = ("planar", "infeasible", "empty", "unbounded", "guaranteed", "infeasible load", "fixed rule")
    results = {kind: result_of(kind, planar_cell, None, lift, tmp_path) for kind in kinds}
    lines = {
        kind: "\n".join([*scaling_lines(result, answer_card(result)), repr(result.range)])
        for kind, result in results.items()
    }
    assert all("inf]" not in text and ", inf" not in text for text in lines.values())
    assert "c² ∈ [0, ∞)" in lines["unbounded"]
    for text in lines.values():
        for low, high in re.findall(r"\[([-\d.e]+), ([-\d.e]+)\]", text):
            assert float(low) <= float(high)


def test_a_load_without_a_common_speed_is_said_with_both_samples(planar_cell, lift):
    slow = braking_only(planar_cell, lift, 53)
    result = mrts.scale(slow.cell.with_variation(mass=(0.9, 1.1)), slow.motion)
    lines = list(scaling_lines(result, answer_card(result)))
    empty = [line for line in lines if line.startswith("  empty (at least")]
    assert len(empty) > 0
    found = result.load.ranges[0]
    assert any(f"{found.lower.c2:.4g} at t = {found.lower.time:.4g} s, but at most" in line for line in empty)


def test_a_plan_at_its_fastest_that_is_read_back_may_be_played_as_given(planar_cell, lift):
    """Its range then ends at 1 but for rounding, to either side."""
    motion = mrts.scale(planar_cell, lift).motion
    end = mrts.scale(planar_cell, motion).range.upper.c2
    chosen = mrts.scale(planar_cell, motion, end * (1 + 5e-8))
    assert chosen.trajectory.c2 == end
    assert _speed_advice((0.0, 1 - 5e-8), 1.0, several=False).startswith("you may play it up to 1 × as fast as given")

"""The best layout of a study: what it gains, that nothing near is better, what a step's program promises; no answer."""

import signal
import threading

import numpy as np
import pytest
import yaml
from draws import draws
from scipy.optimize import minimize
from shipped_cells import DATA, shipped, shipped_motion
from study_files import write_study

import mrts
from mrts.studies.place import LayoutSearch


def c2_of(study, values):
    """c²⁺ of a layout as `mrts.scale` finds it at the samples alone; minus infinity where it cannot be played."""
    keys, asked = study.descriptions(values)[0], study.question
    try:
        cell = mrts.Cell.from_description(keys, folder=study.folder)
        motion = mrts.load_motion(study.motion)
        return mrts.scale(cell, motion, load=asked.load, reserve=asked.reserve, between=None).range.c2_upper
    except mrts.MrtsError:
        return -np.inf


BETTER = 1e-3
"""Share of c²⁺ by which no other search may be better."""

SAME = 1e-9
"""Share of c²⁺ by which two solutions of the same programs differ: rounding."""

LIFT = DATA / "planar_dual_arm" / "lift.yaml"
PLANAR_VARY = {
    "robots.left.base.xyz[0]": {"from": -0.3, "to": 0.3},
    "robots.left.base.xyz[1]": {"from": -0.3, "to": 0.3},
    "robots.right.base.xyz[0]": {"from": 2.2, "to": 2.8},
    "robots.right.grasp.xyz[1]": {"from": -0.1, "to": 0.1},
}


@pytest.mark.quick
def test_the_shipped_study_gains_and_its_answer_is_what_scale_says(tmp_path):
    found = mrts.place(DATA / "dual_ur5" / "place.yaml", starts=1, looked_at=8)
    assert found.gain >= 0.2
    found.write(tmp_path / "best.yaml")
    motion = mrts.load_motion(DATA / "dual_ur5" / "lift_and_turn.yaml")
    again = mrts.scale(mrts.load_cell(tmp_path / "best.yaml"), motion)
    before = mrts.scale(mrts.load_cell(DATA / "dual_ur5" / "poor_cell.yaml"), motion)
    assert again.range.upper.c2 == pytest.approx(found.after.c2, rel=SAME)
    assert before.range.upper.c2 == pytest.approx(found.before.c2, rel=SAME)
    assert not again.excess.passes
    moved = {path: after - was for path, _, was, after in found.moved()}
    assert moved["robots.right.base.xyz[0]"] == -moved["robots.left.base.xyz[0]"]
    assert moved["robots.left.base.xyz[1]"] == 0  # it gains nothing: the right arm is what binds


@pytest.mark.slow
def test_no_other_search_finds_better_on_the_planar_cell(tmp_path):
    path = write_study(tmp_path, shipped("planar_dual_arm"), LIFT, PLANAR_VARY)
    study = mrts.read_study(path)
    found = mrts.place(path, between=None)
    bounds = np.array([parameter.distribution.numbers for parameter in study.parameters])
    rng = np.random.default_rng(7)
    starts = [found.after.values, *(rng.uniform(*bounds.T) for _ in range(draws(1)))]
    for start in starts:
        other = minimize(
            lambda values: -max(c2_of(study, values), 0.0),
            start,
            method="Nelder-Mead",
            bounds=bounds,
            options={"maxfev": 120, "xatol": 1e-5, "fatol": 1e-7},
        )
        assert -other.fun <= found.after.c2 * (1 + BETTER)
    assert found.after.c2 > c2_of(study, study.points(0, 1)[0])


def test_a_posture_that_changes_no_row_stays(tmp_path):
    """It says which way an arm holds the object: with another the arms would be elsewhere than in the program."""
    postures = {f"robots.{arm}.posture[1]": {"from": -3.0, "to": 3.0} for arm in ("left", "right")}
    path = write_study(tmp_path, shipped("planar_dual_arm"), LIFT, PLANAR_VARY | postures)
    search = LayoutSearch(mrts.read_study(path))
    change, promised = search.program(search.given)(np.full(6, -0.1), np.full(6, 0.1))
    assert promised > search.given.c2
    assert [change[place] == 0 for place in range(6)] == ["posture" in one.path for one in search.study.parameters]


def test_ctrl_c_keeps_the_best_so_far(tmp_path):
    path = write_study(tmp_path, shipped("planar_dual_arm"), LIFT, PLANAR_VARY)

    def press(done, _total):
        if done == 65 and not pressed:
            pressed.append(done)
            threading.Timer(0.01, signal.raise_signal, [signal.SIGINT]).start()

    pressed: list[int] = []
    before = signal.getsignal(signal.SIGINT)
    found = mrts.place(path, starts=1000, looked_at=64, progress=press)
    assert pressed
    assert found.interrupted
    assert found.after.c2 > found.before.c2
    assert signal.getsignal(signal.SIGINT) is before


def test_what_is_no_layout_and_wrong_arguments_are_refused_by_name(tmp_path):
    base = "robots.left.base.xyz[0]"
    for vary, words in (
        ({"object.mass": {"from": 1, "to": 2}}, ["object.mass", "no number of a layout", "mrts sweep"]),
        ({base: [0, 0.1]}, [base, "'from' and 'to'"]),
        ({base: {"normal": {"mean": 0, "std": 0.1}}}, ["normal", "'from' and 'to'"]),
    ):
        path = write_study(tmp_path, shipped("planar_dual_arm"), LIFT, vary)
        with pytest.raises(mrts.InputError) as error:
            mrts.place(path)
        assert all(word in str(error.value) for word in [str(path), *words])
    path = write_study(tmp_path, shipped("planar_dual_arm"), LIFT, PLANAR_VARY)
    for argument, value in (("starts", 0), ("looked_at", 1.5), ("progress", 3)):
        with pytest.raises(mrts.InputError, match=argument):
            mrts.place(path, **{argument: value})


UR5_VARY = {
    "distance": {"sets": {"robots.left.base.xyz[0]": -1, "robots.right.base.xyz[0]": 1}, "from": 0.7, "to": 0.8},
    "robots.right.base.xyz[1]": {"from": -0.05, "to": 0.05},
}


def test_points_of_arms_are_searched_with(tmp_path):
    cell = shipped("dual_ur5", frames=[{"link": "wrist_1", "speed": 0.45, "acceleration": 4.0}])
    path = write_study(tmp_path, cell, DATA / "dual_ur5" / "lift_and_turn.yaml", UR5_VARY)
    found = mrts.place(path, starts=1, looked_at=4, between=None)
    assert found.after.c2 > found.before.c2
    assert {row.name.element for row in found.after.result.range.upper.rows} == {"wrist_1"}


STEP = 1e-5
"""Of central differences [m, rad]: their error is its square, 1e-10, times third derivatives, and rounding of c²⁺,
1e-12, over it."""

SAME_SLOPE = 1e-5
"""Of ∂ ln c²⁺/∂θ [1/m, 1/rad]: what differences leave, of `scale` and of the program's rows."""

ASKED = 1e-4
"""To either side, by which the program of a step is asked [m, rad]."""

SAMPLES = 41
"""Of a motion here."""

TURNED_UR5 = {
    "distance": {"sets": {"robots.left.base.xyz[0]": -1, "robots.right.base.xyz[0]": 1}, "from": 0.65, "to": 0.85},
    "robots.right.base.xyz[1]": {"from": -0.1, "to": 0.1},
    "robots.right.base.rpy[2]": {"from": 2.9, "to": 3.3},
    "robots.right.grasp.xyz[2]": {"from": -0.04, "to": 0.04},
    "robots.right.grasp.rpy[2]": {"from": -0.2, "to": 0.2},
}
TURNED_PLANAR = {
    "robots.left.base.xyz[0]": {"from": -0.2, "to": 0.2},
    "robots.left.base.rpy[2]": {"from": -0.2, "to": 0.2},
    "robots.right.base.xyz[1]": {"from": -0.2, "to": 0.2},
    "robots.right.grasp.xyz[1]": {"from": -0.1, "to": 0.1},
}
MOTORS = {"armature": 0.5, "friction": {"coulomb": 2.0, "viscous": 3.0}, "torque_speed": [[0, 160], [1, 160], [5, 30]]}

CASES = {
    "dual": {"cell": "dual_ur5"},
    "planar": {"cell": "planar_dual_arm", "reserve": 0.1},
    "pads in tip axes, which turn with the grasps": {"cell": "squeeze"},
    "motors": {"cell": "dual_ur5", "motors": MOTORS, "torque": [150, 150, 150, 60, 60, 60]},
    "uncertain load": {"cell": "dual_ur5", "variation": {"mass": [0.5, 1.5], "mz": [-0.5, 0.5]}},
}


def study_of(folder, cell, variation=None, reserve=None, **robots):
    """A study of a shipped cell, its motion with fewer samples."""
    keys, motion = shipped(cell, **robots), folder / "motion.yaml"
    keys["object"] |= {} if variation is None else {"variation": variation}
    motion.write_text(yaml.safe_dump(shipped_motion(cell, samples=SAMPLES)), encoding="utf-8")
    vary = TURNED_PLANAR if cell == "planar_dual_arm" else TURNED_UR5
    return write_study(folder, keys, motion, vary, **({} if reserve is None else {"reserve": reserve}))


def promised_slope(study, values):
    """What the program of a step says of the change of ln c²⁺, Shape (P,): it is linear there but for kinks."""
    search = LayoutSearch(study)
    program = search.program(search.tried(values))
    promised = [[program(side * step, side * step)[1] for side in (1, -1)] for step in ASKED * np.eye(len(values))]
    return np.log(promised) @ [1, -1] / (2 * ASKED)


@pytest.mark.parametrize(
    "name", ["motors", *(pytest.param(name, marks=pytest.mark.slow) for name in CASES if name != "motors")]
)
def test_the_slope_is_that_of_scale(name, tmp_path):
    study = mrts.read_study(study_of(tmp_path, **CASES[name]))
    bounds = np.array([parameter.distribution.numbers for parameter in study.parameters])
    rng = np.random.default_rng(5)
    slopes = []
    while len(slopes) < draws(1):
        values = bounds[:, 0] + rng.uniform(0.2, 0.8, len(bounds)) * (bounds[:, 1] - bounds[:, 0])
        c2 = c2_of(study, values)
        around = np.array(
            [[c2_of(study, values + side * step) for side in (1, -1)] for step in STEP * np.eye(len(bounds))]
        )
        one_sided = np.log(around / c2) * [1, -1] / STEP
        if np.max(np.abs(one_sided[:, 0] - one_sided[:, 1])) > 1e-2:
            continue  # a kink: another row binds on the other side
        slope = promised_slope(study, values)
        np.testing.assert_allclose(slope, np.mean(one_sided, axis=1), atol=SAME_SLOPE, rtol=SAME_SLOPE)
        slopes.append(slope)
    assert np.max(np.abs(slopes)) > 0.1

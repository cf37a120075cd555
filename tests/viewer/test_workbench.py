"""The workbench: what changes lead to, the order of answers, and arms that do not reach.

The work is the real one; where its order matters it waits at a gate for the test, so that no clock decides.
"""

from dataclasses import replace
from threading import Event

import numpy as np
import pytest
import yaml
from shown_viewer import PATIENCE, answered, news_of, planar_given, spatial_given

import mrts
from mrts.following.bodies import tip_at_posture
from mrts.motion.motion_file import MotionDescription
from mrts.plots.plot import Line
from mrts.viewer import workbench
from mrts.viewer.panel import held_html
from mrts.viewer.time_plots import time_panels
from mrts.viewer.workbench import Choices, Given, Place, Workbench, changed_keys, find_answer, places

SAME = 1e-9
"""Of numbers that were found twice by the same programs from numbers that passed through a text."""


@pytest.fixture
def planar(planar_cell):
    return planar_given(planar_cell)


@pytest.fixture
def spatial(dual_ur5):
    return spatial_given(dual_ur5)


@pytest.fixture
def fine(spatial):
    """A workbench whose motion has some samples more."""
    keys = {key: value for key, value in spatial.description if value is not None} | {"samples": 201}
    opened = Workbench(Given(spatial.cell, mrts.load_motion(keys), MotionDescription(**keys)))
    answered(opened)
    yield opened
    opened.close()


def changed(given, choices):
    bench = Workbench(given)
    bench.edit(choices)
    return answered(bench)


def upper(answer):
    return answer.state.result.range.upper.c2


def test_each_change_has_the_answer_of_the_changed_cell(spatial):
    """The independent side changes the cell by its own methods and asks `mrts.scale` and `mrts.retime`."""
    cell, motion = spatial.cell, spatial.motion
    bench = Workbench(spatial)
    base, grasp = Place("base", "left"), Place("grasp", "right")
    shifted, regrasped = np.array([0.02, -0.01, 0.0, 0.0, 0.0, 0.05]), np.array([0.0, 0.01, 0.0, 0.0, 0.0, 0.0])
    start = bench.choices
    left = cell.robots[0]
    limits = left.torque_upper * np.where(np.array(left.joints) == "elbow", 0.2, 1.0)
    by_hand = {"xyz": [-0.78, -0.01, 0.0], "rpy": [0, 0, 0.05]}
    cases = {
        "mass": (replace(start, mass=11.0), cell.with_mass(11.0)),
        "limit": (start.with_limit(("torque", "left", "elbow"), 0.2), cell.with_values({"robots.left.torque": limits})),
        "base": (start.with_offset(base, shifted), cell.with_values({"robots.left.base": by_hand})),
        "grasp": (start.with_offset(grasp, regrasped), cell.with_values({"robots.right.grasp.xyz": [0.25, 0.01, 0.0]})),
    }
    for name, (choices, wanted) in cases.items():
        bench.edit(choices)
        assert upper(answered(bench)) == pytest.approx(mrts.scale(wanted, motion).range.upper.c2, rel=SAME), name
    bench.edit(replace(start, profile="optimal"))
    assert answered(bench).state.trajectory.duration == pytest.approx(mrts.retime(cell, motion).duration, rel=SAME)
    shares = mrts.LoadSharing(np.array([0.7, 0.3]))
    fixed = mrts.scale(cell.with_mass(9.0), motion, sharing=shares)
    answer = changed(replace(spatial, asked={"sharing": shares}), Choices(mass=9.0))
    assert upper(answer) == pytest.approx(fixed.range.upper.c2, rel=SAME)


def test_a_motion_is_played_in_closed_loop_when_asked(planar):
    """As `mrts.simulate` finds it, anew for another mass; a plot has its shares along the time of the plan."""
    bench = Workbench(planar)
    answered(bench)
    assert bench.answer.simulation is None
    for mass in (None, 2.0):
        bench.edit(Choices(mass=mass, simulated=True))
        answer = answered(bench)
        found = mrts.simulate(answer.state.trajectory)
        assert answer.simulation.passed[0].share == found.passed[0].share
        panel = time_panels(answer.state.played, answer.simulation)["In closed loop"]
        lines = [item for item in panel.items if isinstance(item, Line)]
        during = found.played.time <= found.plan.duration
        most = np.max(found.played.quantities.limited.share[during])
        assert max(np.max(line.y) for line in lines) == pytest.approx(100 * most)
    bench.edit(Choices())
    assert answered(bench).simulation is None


def test_the_keys_of_what_was_changed_are_those_of_the_files(spatial):
    """Read as YAML and put into the cell and the motion, they give the answer of the workbench."""
    base, end = Place("base", "left"), Place("end")
    choices = Choices(mass=9.5).with_limit(("torque", "left", "elbow"), 0.5)
    choices = choices.with_offset(end, np.array([0, 0, 0.05, 0, 0, 0]))
    choices = choices.with_offset(base, np.array([0.02, 0, 0, 0, 0, 0.1]))
    keys = dict(yaml.safe_load(line).popitem() for line in changed_keys(spatial, choices))
    ends = {"end": keys.pop("end")}
    assert keys.keys() == {"object.mass", "robots.left.torque", "robots.left.base"}
    motion = mrts.load_motion({key: value for key, value in spatial.description if value is not None} | ends)
    found = mrts.scale(spatial.cell.with_values(keys), motion)
    assert upper(changed(spatial, choices)) == pytest.approx(found.range.upper.c2, rel=SAME)
    assert changed_keys(spatial, Choices()) == []


def test_the_newest_of_many_changes_is_answered(planar):
    bench = Workbench(planar)
    first = upper(bench.answer)
    for mass in np.linspace(0.6, 2.0, 40):
        bench.edit(replace(bench.choices, mass=float(mass)))
    assert bench.is_asked
    assert answered(bench).choices.mass == 2.0
    assert not bench.is_asked
    bench.edit(replace(bench.choices, mass=-1.0))
    assert "object.mass" in str(answered(bench).shown)
    bench.edit(Choices())
    assert upper(answered(bench)) == first


def test_an_arm_that_does_not_reach_is_shown_as_near_as_it_comes(spatial):
    """The gap is the distance from the drawn tip to the grasp; the object still moves."""
    end = Place("end")
    answer = changed(spatial, Choices().with_offset(end, np.array([0.0, 0.0, 0.6, 0, 0, 0])))
    found = answer.shown
    assert answer.state is None
    assert "cannot reach" in found.message
    lost = int(np.flatnonzero(~np.all(found.reached, axis=1))[0])
    assert 0 < lost < len(found.scene.time) - 1
    scene = found.scene
    for sample in (0, lost, len(found.scene.time) - 1):
        for index, (robot, line) in enumerate(zip(scene.cell.robots, scene.lines, strict=True)):
            grasp = scene.position[sample] + scene.rotation[sample] @ robot.T_object_tip.p
            distance = np.linalg.norm(line[sample, -1] - grasp)
            assert distance == pytest.approx(found.gap[sample, index], abs=1e-9)
    assert np.max(found.gap[-1]) > 0.05


def test_a_cell_without_a_motion_stands_at_its_posture_and_follows_its_places(planar_cell):
    bench = Workbench(Given(planar_cell, None))
    held, robot = bench.answer.shown, planar_cell.robots[0]
    assert held.reached.all()
    np.testing.assert_allclose(held.scene.q[0, :3], robot.posture, atol=1e-6)
    grasp = held.scene.position[0] + held.scene.rotation[0] @ robot.T_object_tip.p
    np.testing.assert_allclose(grasp, tip_at_posture(robot).p, atol=1e-6)
    bench.edit(bench.choices.with_offset(Place("base", "left"), np.array([0.0, -3.0, 0, 0, 0, 0])))
    held = answered(bench).shown
    assert held.reached[0].tolist() == [False, True]
    assert held_html(held).count("mm") == 1


def test_the_ends_of_a_joint_table_cannot_be_moved(planar, tmp_path):
    followed = mrts.follow_object(planar.cell, planar.motion)
    names = [f"{robot.name}/{joint}" for robot in planar.cell.robots for joint in robot.joints]
    columns = [dict(zip(names, part.T, strict=True)) for part in (followed.q, followed.dq, followed.ddq)]
    table = mrts.JointTable(tmp_path / "joints.csv", planar.motion.time, *columns)
    bench = Workbench(Given(planar.cell, table))
    assert {place.kind for place in places(bench.given)} == {"base", "grasp"}


class Gate:
    """A place that work does not pass before it is opened."""

    def __init__(self):
        self.reached, self.opened = Event(), Event()

    def wait(self):
        self.reached.set()
        assert self.opened.wait(PATIENCE)


def test_an_answer_comes_again_with_its_collisions(fine):
    fine.edit(Choices(profile="smooth", mass=9.0))
    whole, looked = news_of(fine)
    assert whole.collisions is None
    assert looked.state is whole.state
    near = mrts.clearance(whole.state.result.cell, whole.state.result.motion)
    assert (looked.collisions[0].distance, looked.collisions[0].pair) == (near.distance, near.pair)
    wanted = mrts.retime(fine.given.cell.with_mass(9.0), fine.given.motion, rates=whole.choices.torque_rate)
    assert whole.state.trajectory.duration == pytest.approx(wanted.duration, rel=SAME)
    fine.edit(replace(fine.choices, speed=0.5))
    (slower,) = news_of(fine)
    assert slower.clearance()[0].time == pytest.approx(2 * near.time)
    assert slower.state.trajectory.duration == pytest.approx(2 * wanted.duration, rel=SAME)


def test_what_is_newer_ends_work_on_an_older_answer(fine, monkeypatch):
    masses = np.linspace(8.1, 9.0, 4).tolist()
    begins = {mass: Gate() for mass in masses[:-1]}

    def find(given, choices, progress):
        if choices.mass in begins:
            begins[choices.mass].wait()
        return find_answer(given, choices, progress)

    monkeypatch.setattr(workbench, "find_answer", find)
    for before, mass in zip([None, *masses], masses, strict=False):
        fine.edit(Choices(profile="smooth", mass=mass))
        if before is not None:
            begins[before].opened.set()
        if mass in begins:
            assert begins[mass].reached.wait(PATIENCE)
    taken = news_of(fine)
    assert [one.choices.mass for one in taken] == 2 * masses[-1:]
    assert [one.collisions is None for one in taken] == [True, False]


def test_a_defect_is_raised_where_answers_are_taken(planar, monkeypatch):
    bench = Workbench(planar)
    monkeypatch.setattr(workbench, "find_answer", lambda *_, **__: 1 / 0)
    bench.edit(Choices(mass=1.0))
    with pytest.raises(ZeroDivisionError):
        news_of(bench)

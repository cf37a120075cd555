"""All inverse-kinematics branches, followed and ranked."""

import json

import numpy as np
import pytest
from conftest import DATA
from six_joint_inverse import six_joint_branches

import mrts
import mrts.studies.configurations
from mrts.cli import main

UR5 = DATA.parent / "dual_ur5"


@pytest.fixture(scope="module")
def lift_and_turn():
    return mrts.load_motion(UR5 / "lift_and_turn.yaml")


@pytest.fixture(scope="module")
def unhurried(dual_ur5):
    """Velocity limits would make many configurations equal."""
    return dual_ur5.without_velocity_limits()


@pytest.fixture(scope="module")
def study(unhurried, lift_and_turn):
    return mrts.rank_configurations(unhurried, lift_and_turn)


def test_velocity_limits_count_in_the_ranking(dual_ur5, lift_and_turn, study):
    ranked = mrts.rank_configurations(dual_ur5, lift_and_turn).ranked
    assert ranked[0].c2_upper < study.ranked[-1].c2_upper
    assert ranked[0].range.upper.rows[0].name.kind == "velocity"
    assert mrts.studies.configurations.outcome(ranked[0]).endswith(" velocity")
    assert "velocity" not in mrts.studies.configurations.outcome(study.ranked[0])


def test_an_uncertain_load_is_ranked_by_its_guaranteed_range(planar_cell, lift):
    uncertain = planar_cell.with_variation(mass=(0.2, 6.0))
    studies = [mrts.rank_configurations(cell, lift) for cell in (uncertain, planar_cell.with_mass(3.0))]
    ours, heaviest = (
        {tuple(branch.number for branch in found.branches): found.c2_upper for found in study.ranked}
        for study in studies
    )
    assert all(ours[branches] <= heaviest[branches] * (1 + 1e-8) for branches in heaviest)
    shipped = mrts.scale(uncertain, lift).range.upper.c2
    assert any(c2 == pytest.approx(shipped, rel=1e-8) for c2 in ours.values())


def test_two_ur5_class_arms_have_eight_times_eight_configurations(study):
    assert {name: len(branches) for name, branches in study.branches.items()} == {"left": 8, "right": 8}
    assert study.combinations == len(study.ranked) == 64
    assert len({tuple(b.number for b in c.branches) for c in study.ranked}) == 64
    values = [configuration.c2_upper for configuration in study.ranked]
    assert values == sorted(values, reverse=True)
    assert values[0] > 1.5 * values[-1]  # the configuration matters


def test_every_branch_holds_the_grasp(study, dual_ur5, lift_and_turn):
    for index, (robot, joints) in enumerate(zip(dual_ur5.robots, dual_ur5.joint_slices.values(), strict=True)):
        starts = np.array([branch.start for branch in study.branches[robot.name]])
        q = np.zeros((8, 12))
        q[:, joints] = starts
        poses = dual_ur5.functions("kinematics", 8, {"q": q})
        wanted = lift_and_turn.position[0] + lift_and_turn.rotation[0] @ robot.T_object_tip.p
        np.testing.assert_allclose(poses["position"][:, :, index], np.broadcast_to(wanted, (8, 3)), atol=1e-10)
        apart = [np.max(np.abs(a - b)) for k, a in enumerate(starts) for b in starts[:k]]
        assert min(apart) > 0.1


def test_random_starts_find_what_an_analytic_inverse_finds(study, unhurried, lift_and_turn):
    for robot in unhurried.robots:
        ours = np.array([branch.start for branch in study.branches[robot.name]])
        theirs = six_joint_branches(robot, lift_and_turn)
        apart = (ours[:, None] - theirs + np.pi) % (2 * np.pi) - np.pi
        assert np.max(np.min(np.max(np.abs(apart), axis=2), axis=0)) < 1e-9
        assert len(theirs) == len(ours) == 8


def test_a_configuration_is_what_scale_finds_from_its_posture(study, unhurried, lift_and_turn):
    for configuration in (study.ranked[0], study.ranked[31], study.ranked[-1]):
        cell = unhurried.with_postures(configuration.postures())
        assert mrts.scale(cell, lift_and_turn).range.upper.c2 == pytest.approx(configuration.c2_upper, rel=1e-9)


def test_the_cap_keeps_the_best_of_the_even_distribution(study, unhurried, lift_and_turn):
    few = mrts.rank_configurations(unhurried, lift_and_turn, cap=5)
    assert few.combinations == 64
    assert len(few.ranked) == 5
    assert few.ranked[0].c2_upper >= study.ranked[20].c2_upper
    assert "5 evaluated" in few.table(3)
    with pytest.raises(mrts.InputError, match="cap"):
        mrts.rank_configurations(unhurried, lift_and_turn, cap=0)


@pytest.mark.quick
def test_the_papers_configurations(planar_cell, lift):
    """Section 6.3: up-up before the two mixed ones before down-down; flipped arms agree with `mrts demo`."""
    study = mrts.rank_configurations(planar_cell, lift)
    assert [configuration.c2_upper for configuration in study.ranked] == pytest.approx(
        [3.0618125, 2.4287932, 2.4287932, 2.4234572], rel=1e-4
    )
    even = mrts.rank_configurations(planar_cell, lift, sharing=mrts.LoadSharing())
    assert even.ranked[0].c2_upper == pytest.approx(2.9598285, rel=1e-6)


def test_branches_that_fail_say_why(dual_ur5):
    description = {
        "duration": 1.0,
        "profile": "quintic",
        "start": {"xyz": [0, 0.15, 0.35]},
        "end": {"xyz": [0.05, 0.3, 0.6], "rpy": [0.2, 0, 0.3]},
    }
    motion = mrts.sample_motion(mrts.MotionDescription.model_validate(description))
    study = mrts.rank_configurations(dual_ur5, motion)
    failures = [b.failure for branches in study.branches.values() for b in branches if b.failure]
    assert failures
    assert all("cannot reach its grasp at sample" in failure.message for failure in failures)
    assert study.combinations < 64
    assert f"by falling c²⁺; branches left out: {len(failures)} out of reach:" in study.table(2).splitlines()[0]
    assert json.loads(study.json_text())["branches"]["left"][0].keys() == {"number", "start", "failure"}


def test_infeasible_configurations_come_last_with_their_reason(dual_ur5, lift_and_turn):
    study = mrts.rank_configurations(dual_ur5.with_mass(60.0), lift_and_turn, cap=4)
    assert study.ranked[-1].c2_upper == -np.inf
    assert "limits conflict" in study.table(10)


def test_an_object_out_of_everyones_reach(dual_ur5):
    description = {"duration": 1.0, "profile": "quintic", "start": {"xyz": [0, 0, 3]}, "end": {"xyz": [0, 0, 3.1]}}
    study = mrts.rank_configurations(dual_ur5, mrts.sample_motion(mrts.MotionDescription.model_validate(description)))
    assert study.combinations == 0
    assert study.ranked == ()
    assert "cannot reach" in study.table(5)


@pytest.mark.quick
def test_the_command(tmp_path, capsys):
    target = tmp_path / "study.json"
    arguments = ["configurations", str(UR5 / "cell.yaml"), str(UR5 / "lift_and_turn.yaml"), "--show", "3"]
    assert main([*arguments, "--json", str(target)]) == 0
    shown = capsys.readouterr().out
    assert "64 configurations reach the end" in shown
    assert shown.count("\n   ") >= 3
    study = json.loads(target.read_text())
    assert len(study["ranked"]) == 64
    assert study["ranked"][0]["c2"]["upper"] > study["ranked"][-1]["c2"]["upper"]
    assert set(study["ranked"][0]["postures"]) == {"left", "right"}


@pytest.mark.parametrize(("cap", "sharing", "total"), [(1024, None, 4), (2, None, 6), (2, mrts.LoadSharing(), 4)])
def test_progress_counts_every_evaluation(planar_cell, lift, cap, sharing, total):
    told = []
    study = mrts.rank_configurations(
        planar_cell, lift, cap=cap, sharing=sharing, progress=lambda *counts: told.append(counts)
    )
    assert told == [(done, total) for done in range(total + 1)]
    assert len(study.ranked) == min(cap, 4)


def test_the_best_of_palms_are_found_although_no_fixed_distribution_squeezes():
    shipped = DATA.parent / "squeeze"
    cell, motion = mrts.load_cell(shipped / "cell.yaml"), mrts.load_motion(shipped / "lift_and_turn.yaml")
    best = mrts.rank_configurations(cell, motion, between=None).ranked[:5]
    few = mrts.rank_configurations(cell, motion, cap=5, between=None).ranked
    assert [one.c2_upper for one in few] == pytest.approx([one.c2_upper for one in best], rel=1e-6)

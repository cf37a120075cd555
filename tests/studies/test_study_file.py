"""The study file: what it may say, what is said of a wrong one; its points: grids, Sobol's sequence, in any block."""

import shutil
from itertools import product

import numpy as np
import pytest
import yaml
from conftest import DATA, ROOT
from scipy import stats
from shipped_cells import shipped, shipped_motion
from study_files import planar_study

import mrts
from mrts.cell.cell_keys import numbers_below, path_text, value_at
from mrts.studies.parameters import Distribution, sample_points
from mrts.studies.variants import batch_for, solve_one_by_one, solve_variants

BASE = "vary: {object.mass: [1, 2]}"

WRONG = yaml.safe_load((ROOT / "tests" / "study_cases" / "wrong_studies.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("case", WRONG.values(), ids=WRONG)
def test_a_wrong_study_is_refused_by_file_key_value_and_rule(case, tmp_path):
    with pytest.raises(mrts.InputError, match=f"^{tmp_path}/study", check=lambda error: case["says"] in str(error)):
        planar_study(tmp_path, case["file"])


def test_paths_lead_to_what_the_files_leave_out(tmp_path):
    study = planar_study(
        tmp_path,
        """
vary:
  robots.left.base.rpy[2]: [0.1]
  robots[1].wrench.upper[1]: [90]
  robots.right.motors.armature[2]: [0.4]
  robots.right.motors.friction.viscous[0]: [0.3]
  robots.left.motors.jerk: [800]
  robots.left.contact_rate[1]: [40]
  object.velocity.linear: [2]
  start.rpy[2]: [0.05]
  object.inertia[1]: [0.1999]
  gravity[1]: [-9]
""",
    )
    assert [(each.path, each.unit) for each in study.parameters] == [
        ("robots.left.base.rpy[2]", "rad"), ("robots.right.wrench.upper[1]", "N"),
        ("robots.right.motors.armature[2]", "kg m²"), ("robots.right.motors.friction.viscous[0]", "N m s/rad"),
        ("robots.left.motors.jerk", "rad/s³"), ("robots.left.contact_rate[1]", "N m/s"),
        ("object.velocity.linear", "m/s"), ("motion.start.rpy[2]", "rad"),
        ("object.inertia[1]", "kg m²"), ("gravity[1]", "m/s²"),
    ]  # fmt: skip
    cell = mrts.load_cell(study.write_variant(0, tmp_path / "variant")[0])
    left, right = cell.robots
    np.testing.assert_allclose(left.T_world_base.R[0, :2], [np.cos(0.1), -np.sin(0.1)], atol=1e-15)
    assert right.wrench_upper.tolist() == [2, 90, 1]
    assert right.motors.armature.tolist() == [0, 0, 0.4]
    assert right.motors.viscous.tolist() == [0.3, 0, 0]
    assert left.motors.jerk.tolist() == [800] * 3
    assert left.contact_rate.tolist() == [np.inf, np.inf, 40]
    assert cell.object_velocity_limit.tolist() == [2, np.inf]
    assert (cell.inertia[1, 1], cell.gravity[1]) == (0.1999, -9)


def test_a_parameter_sets_shifts_and_scales(tmp_path):
    study = planar_study(
        tmp_path,
        """
vary:
  apart:
    sets:
      robots.left.base.xyz[0]: -1
      robots.right.base.xyz[0]: 11
    values: [0.25]
  lift:
    shifts: [motion.start.xyz, motion.end]
    values: [0.5]
  light:
    scales: [object.mass, object.inertia]
    values: [0.5]
""",
    )
    cell, motion = study.descriptions(study.points(0, 1)[0])
    assert [robot["base"]["xyz"] for robot in cell["robots"]] == [[-0.25, 0, 0], [2.75, 0, 0]]
    assert (motion["start"]["xyz"], motion["end"]["xyz"]) == ([1.75, 1.5, 0.5], [1.75, 2.0, 0.5])
    assert motion["end"]["rpy"] == [0.5, 0.5, 0.5]
    assert (cell["object"]["mass"], cell["object"]["inertia"]) == (0.25, [0.00025, 0.1, 0.1])
    assert [each.unit for each in study.parameters] == ["m", "", ""]  # an end is a place and a rotation


def test_the_digest_is_of_all_that_answers_depend_on_and_of_nothing_else(tmp_path):
    cell = tmp_path / "cell.yaml"
    urdf = tmp_path / "planar_arm.urdf"
    shutil.copy(DATA / "cell.yaml", cell)
    shutil.copy(DATA / "planar_arm.urdf", urdf)
    digests = [planar_study(tmp_path, text, cell=cell).digest for text in (BASE, f"# a comment\n{BASE}")]
    assert digests[0] == digests[1]
    others = ("vary: {object.mass: [1, 3]}", f"{BASE}\nreserve: 0.1", f"{BASE}\nbetween: 0.001")
    digests += [planar_study(tmp_path, text, cell=cell).digest for text in others]
    digests.append(planar_study(tmp_path, BASE, cell=cell, motion=DATA / "fast_lift.yaml").digest)
    cell.write_text(cell.read_text(encoding="utf-8").replace("100, 80, 50", "100, 80, 51"), encoding="utf-8")
    digests.append(planar_study(tmp_path, BASE, cell=cell).digest)
    urdf.write_text(urdf.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    digests.append(planar_study(tmp_path, BASE, cell=cell).digest)
    assert len({*digests}) == len(digests) - 1


@pytest.mark.parametrize("folder", ["dual_ur5", "planar_dual_arm", "squeeze"])
def test_every_number_of_the_files_may_vary_and_at_its_own_value_changes_nothing(folder, tmp_path):
    files = {"cell": DATA.parent / folder / "cell.yaml"}
    files["motion"] = files["cell"].with_name("lift.yaml" if folder == "planar_dual_arm" else "lift_and_turn.yaml")
    keys = {name: yaml.safe_load(path.read_text(encoding="utf-8")) for name, path in files.items()}
    own = [place for name in keys for place in numbers_below(keys, (name,)) if place != ("motion", "samples")]
    vary = {path_text(keys, place): [value_at(keys, place)] for place in own}
    assert len(vary) >= 50
    text = yaml.safe_dump({"vary": vary})
    study = planar_study(tmp_path, text, cell=files["cell"], motion=files["motion"])
    assert study.variants == 1
    assert study.descriptions(study.points(0, 1)[0]) == (keys["cell"], keys["motion"])
    described = mrts.Cell.from_description(study.cell, folder=study.folder)
    expected = mrts.scale(described, mrts.load_motion(files["motion"]), between=None)
    assert solve_variants(study, 0, 1)["c2_upper"] == [pytest.approx(expected.range.upper.c2, rel=1e-9)]
    for move, neutral in (("scales", 1), ("shifts", 0)):
        knob = {"all": {move: [path for path, (value,) in vary.items() if value != 0], "values": [neutral]}}
        moved = planar_study(tmp_path, yaml.safe_dump({"vary": knob}), cell=files["cell"], motion=files["motion"])
        assert moved.descriptions(moved.points(0, 1)[0]) == (keys["cell"], keys["motion"])


def test_variants_all_at_once_stand_where_their_files_say(tmp_path):
    """The right tip is turned by half a turn, which its file says by a quaternion."""
    cell, motion = shipped("planar_dual_arm"), shipped_motion()
    cell["robots"][1]["grasp"] = {"xyz": [1.1, 0, 0], "quaternion_wxyz": [0, 0, 0, 1]}
    motion["start"] = {"xyz": motion["start"]["xyz"], "quaternion_wxyz": [1, 0, 0, 0]}
    vary = {"robots.right.grasp.xyz[1]": [-0.01, 0.02], "motion.start.rpy[2]": [0.0, 0.1]}
    one = planar_study(tmp_path, yaml.safe_dump({"vary": vary}), cell=cell, motion=motion)
    batch, points = batch_for(one), one.points(0, 4)
    at_once, alone = batch.solve(points, 0), solve_one_by_one(one, points, 0)
    assert at_once["c2_upper"] == pytest.approx(alone["c2_upper"], rel=1e-9)
    assert all(at_once["c2_upper"])


QUANTILE_TOLERANCE = 1e-12
"""Share by which two ways to evaluate a quantile may differ: rounding."""

ANY = [
    Distribution("values", (3.0, 1.0, 2.0)),
    Distribution("uniform", (-2.0, 5.0)),
    Distribution("normal", (1.0, 0.1)),
    Distribution("uniform", (0.0, 1e-3)),
]


def test_a_grid_takes_every_combination_the_last_number_fastest():
    distributions = [
        Distribution("values", (1.0, 2.0)),
        Distribution("values", (10.0,)),
        Distribution("values", (0.5, 0.25, 0.125)),
    ]
    expected = list(product(*(distribution.levels for distribution in distributions)))
    np.testing.assert_array_equal(sample_points(distributions, "grid", 0, (0, 6)), expected)


@pytest.mark.parametrize("sample", ["grid", "sobol"])
def test_points_are_the_same_in_any_block(sample):
    distributions = (
        [Distribution("values", tuple(np.linspace(0, 1, levels))) for levels in (7, 5, 4)] if sample == "grid" else ANY
    )
    count = 140
    whole = sample_points(distributions, sample, 3, (0, count))
    assert whole.shape == (count, len(distributions))
    rng = np.random.default_rng(1)
    for first, last in np.sort(rng.integers(0, count + 1, (30, 2)), axis=1).tolist():
        if first < last:
            np.testing.assert_array_equal(sample_points(distributions, sample, 3, (first, last)), whole[first:last])
    if sample != "grid":
        assert np.any(sample_points(distributions, sample, 4, (0, count)) != whole)


@pytest.mark.parametrize(
    ("distribution", "reference"),
    [
        (Distribution("uniform", (-2.0, 5.0)), stats.uniform(-2, 7)),
        (Distribution("normal", (3.0, 0.2)), stats.norm(3, 0.2)),
    ],
)
def test_quantiles_are_those_of_scipy(distribution, reference):
    probability = np.random.default_rng(2).random(500)
    np.testing.assert_allclose(
        distribution.at(probability), reference.ppf(probability), rtol=QUANTILE_TOLERANCE, atol=1e-15
    )
    ends = distribution.at(np.array([0.0, 1.0]))
    assert np.all(np.isfinite(ends))
    if distribution.kind == "uniform":
        assert tuple(ends) == pytest.approx(distribution.numbers)

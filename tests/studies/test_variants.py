"""Rows of a study: what `mrts.scale` says of each variant's files, solved at once or one by one; else a reason."""

from collections import Counter

import cell_bank
import numpy as np
import pytest
from conftest import DATA, UR5
from draws import draws
from shipped_cells import changed_cell, shipped
from study_files import planar_study
from wide_studies import wide_study

import mrts
from mrts.studies.variants import batch_for, column_types, solve_one_by_one, solve_variants

SAME = 1e-9
"""Share by which answers may differ: matrices are rounded once more through a file, programs start elsewhere."""

REFUSED = {"invalid": mrts.InputError, "unreachable": mrts.MotionError}
"""What `mrts.scale` raises of files whose rows have these statuses."""

WIDE = """
vary:
  robots.left.base.xyz[0]: {from: -1.5, to: 0.5}
  robots.right.grasp.xyz[1]: {from: -0.2, to: 0.2}
  object.mass: {normal: {mean: 0.4, std: 0.4}}
  robots.left.wrench.lower[0]: {from: -30, to: 1}
  motion.duration: {from: 0.2, to: 2}
  strength: {scales: [robots.left.torque, robots.right.torque], from: 0.02, to: 2}
sample: sobol
count: 48
seed: 3
"""
"""Masses below 0, lower wrench limits above upper ones, and arms that do not reach are among the variants."""


def rows_of(columns):
    names = list(columns)
    return [dict(zip(names, values, strict=True)) for values in zip(*columns.values(), strict=True)]


def scaled(study, index, folder, **options):
    cell, motion = study.write_variant(index, folder)
    return mrts.scale(mrts.load_cell(cell), mrts.load_motion(motion), **options)


@pytest.fixture(scope="module")
def wide(tmp_path_factory):
    return planar_study(tmp_path_factory.mktemp("wide"), WIDE)


def test_each_row_is_what_scale_says_of_the_files_of_its_variant(wide, tmp_path):
    rows = rows_of(solve_variants(wide, 0, wide.variants))
    assert {"feasible", "infeasible", "unreachable", "invalid"} <= {row["status"] for row in rows}
    assert [row["variant"] for row in rows] == list(range(wide.variants))
    assert list(column_types(wide)) == list(rows[0])
    for row in rows:
        folder = tmp_path / str(row["variant"])
        if row["status"] in REFUSED:
            with pytest.raises(REFUSED[row["status"]]) as raised:
                scaled(wide, row["variant"], folder, between=None)
            assert str(raised.value).endswith(row["reason"].removeprefix("cell description"))
            continue
        result = scaled(wide, row["variant"], folder, between=None)
        assert row["status"] == result.status.value
        if not result.status.admits_motion:
            variant = row["variant"]
            alone = solve_one_by_one(wide, wide.points(variant, variant + 1), variant)
            assert alone["reason"] == [result.range.explain()]
            assert "at t = " in row["reason"]  # of many at once it may be shorter
            assert row["c2_upper"] is None
            continue
        assert row["reason"] is None
        assert row["c2_upper"] == pytest.approx(result.range.upper.c2, rel=SAME)
        assert row["c2_lower"] == pytest.approx(result.range.lower.c2, rel=SAME)
        assert row["lower_limit"] is None
        assert row["duration"] == pytest.approx(result.trajectory.duration, rel=SAME)
        assert row["upper_limit"] == ", ".join(limit.label for limit in result.range.upper.rows)
        assert row["upper_time"] == pytest.approx(result.range.upper.time)


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        ("vary: {object.mass: [0.4, 0.8]}\nreserve: 0.1\nbetween: 0.001", {"reserve": 0.1, "between": 0.001}),
        ("vary: {object.mass: [0.4, 0.8]}\nreserve: 0.1", {"reserve": 0.1, "between": None}),
        ("vary:\n  object.variation.mass[1]: [1.5, 3]", {"load": "guaranteed", "between": None}),
    ],
)
def test_questions_of_a_study_are_those_of_scale(text, asked, tmp_path):
    cell = shipped("planar_dual_arm")
    cell["object"] |= {"variation": {"mass": [0.5, 1.5]}} if "load" in asked else {}
    study = planar_study(tmp_path, text, cell=cell)
    for row in rows_of(solve_variants(study, 0, 2)):
        result = scaled(study, row["variant"], tmp_path / str(row["variant"]), **asked)
        assert row["c2_upper"] == pytest.approx(result.range.upper.c2, rel=SAME)


def test_the_optimal_profile_gives_its_duration_beside_the_constant_range(tmp_path):
    study = planar_study(tmp_path, "vary: {object.mass: [0.4, 100]}\nprofile: optimal")
    fast, heavy = rows_of(solve_variants(study, 0, 2))
    cell, motion = study.write_variant(0, tmp_path / "fast")
    found = mrts.retime(mrts.load_cell(cell), mrts.load_motion(motion), between=None)
    assert fast["status"] == "feasible"
    assert fast["duration"] == pytest.approx(found.duration, rel=SAME)
    assert fast["c2_upper"] == pytest.approx(found.constant.range.upper.c2, rel=SAME)
    assert (heavy["status"], heavy["duration"]) == ("infeasible", None)


def test_a_defect_is_a_row_and_an_interrupt_is_not(wide):
    def broken(_cell, _motion):
        raise ZeroDivisionError("of mine")

    def interrupted(_cell, _motion):
        raise KeyboardInterrupt

    feasible = solve_one_by_one(wide.with_limits(broken), wide.points(0, 8), 0)
    assert "failed" in feasible["status"]
    place = feasible["status"].index("failed")
    assert feasible["reason"][place] == "ZeroDivisionError: of mine"
    with pytest.raises(KeyboardInterrupt):
        solve_one_by_one(wide.with_limits(interrupted), wide.points(0, 8), 0)


SQUEEZE = DATA.parent / "squeeze"

SHIPPED = {
    "dual": (UR5 / "cell.yaml", UR5 / "lift_and_turn.yaml"),
    "planar": (DATA / "cell.yaml", DATA / "lift.yaml"),
    "squeeze": (SQUEEZE / "cell.yaml", SQUEEZE / "lift_and_turn.yaml"),
}

STUDIES = {
    "dual near": ("dual", {"spread": 0.05, "count": 10}),
    "dual far": ("dual", {"spread": 0.3, "count": 20}),
    "dual heavy": ("dual", {"spread": 0.02, "count": 15, "limits": 0.5, "mass": (5, 15)}),
    "planar near": ("planar", {"spread": 0.1, "count": 20}),
    "planar far": ("planar", {"spread": 0.6, "count": 40, "inertia": 0.01}),
    "planar heavy": ("planar", {"spread": 0.02, "count": 15, "limits": 0.5, "mass": (1, 20)}),
    "squeeze": ("squeeze", {"spread": 0.03, "count": 12, "mass": (0.5, 1.5)}),
    "squeeze heavy": ("squeeze", {"spread": 0.05, "count": 12, "mass": (1, 3)}),
}
SEEN = {
    "dual far": {"unreachable", "feasible"},
    "dual heavy": {"infeasible", "feasible"},
    "planar far": {"unreachable", "invalid"},
    "planar heavy": {"infeasible"},
    "squeeze heavy": {"infeasible"},
}
"""Outcomes that must be among them."""


def compare(study, count):
    """Solve variants both ways and compare every column; gives how often each outcome was met."""
    points = study.points(0, count)
    batch = batch_for(study)
    assert batch is not None
    at_once, one_by_one = batch.solve(points, 0), solve_one_by_one(study, points, 0)
    assert list(at_once) == list(one_by_one) == list(column_types(study))
    for name, kind in column_types(study).items():
        for variant, (ours, theirs) in enumerate(zip(at_once[name], one_by_one[name], strict=True)):
            where = f"variant {variant}, {name}: {ours!r} at once, {theirs!r} alone"
            if kind == "float64" and ours is not None and theirs is not None:
                assert ours == pytest.approx(theirs, rel=SAME), where
            elif name == "reason" and at_once["status"][variant] == "infeasible":
                assert "limits conflict" in ours, where  # of the first sample that is found, not of the worst
            else:
                assert ours == theirs, where
    return Counter(at_once["status"])


@pytest.mark.parametrize("name", STUDIES)
def test_variants_of_shipped_cells(name, tmp_path):
    cell, how = STUDIES[name]
    count = draws(how["count"])
    met = compare(wide_study(tmp_path, *SHIPPED[cell], **how | {"count": count}), count)
    assert met.keys() >= SEEN.get(name, {"feasible"}), met


def of_joints(cell):
    for robot, least in zip(cell["robots"], (-2, -30), strict=True):
        robot["acceleration"] = {"lower": [least] * 6, "upper": [20] * 6}


def of_object(cell):
    cell["object"]["acceleration"] = {"linear": 0.5, "angular": 8}


@pytest.mark.parametrize(("limits", "bound"), [(of_joints, "left/elbow"), (of_object, "object/linear")])
def test_accelerations_bound_variants(limits, bound, tmp_path):
    path = changed_cell(tmp_path, limits, "dual_ur5")
    study = wide_study(tmp_path, path, UR5 / "lift_and_turn.yaml", spread=0.1, count=12)
    assert compare(study, 12)["feasible"] > 0
    assert f"{bound} acceleration" in batch_for(study).solve(study.points(0, 12), 0)["upper_limit"]


@pytest.mark.parametrize(("draw", "arms", "seed"), [
    (cell_bank.random_planar_cell, 3, 1),
    (cell_bank.random_spatial_cell, 2, 3),
    pytest.param(cell_bank.random_planar_cell, 2, 2, marks=pytest.mark.slow),
    pytest.param(cell_bank.random_spatial_cell, 3, 4, marks=pytest.mark.slow),
])  # fmt: skip
def test_variants_of_random_cells(draw, arms, seed, tmp_path):
    drawn = draw(np.random.default_rng(seed), tmp_path, arms)
    count = draws(15)
    compare(wide_study(tmp_path, drawn.cell_file, drawn.motion_file, spread=0.02, count=count, seed=seed), count)


def test_a_variant_has_the_same_bits_whatever_it_is_solved_with(tmp_path):
    study = wide_study(tmp_path, *SHIPPED["dual"], spread=0.2, count=40)
    batch = batch_for(study)
    whole = batch.solve(study.points(0, 40), 0)
    pieces = [batch.solve(study.points(first, last), first) for first, last in ((0, 1), (1, 18), (18, 40))]
    for name, values in whole.items():
        assert list(values) == [value for piece in pieces for value in piece[name]], name


@pytest.mark.parametrize(("asked", "robots"), [
    ("profile: optimal", {}),
    ("between: 1e-3", {}),
    ("", {"motors": {"armature": 0.5}}),
    ("", {"motors": {"torque_speed": [[0, 100], [20, 10]]}}),
])  # fmt: skip
def test_what_it_does_not_cover_is_solved_one_by_one(asked, robots, tmp_path):
    cell = shipped("planar_dual_arm", **robots)
    study = planar_study(tmp_path, f"{asked}\nvary: {{object.mass: [1, 2]}}", cell=cell)
    assert batch_for(study) is None
    assert solve_variants(study, 0, 2)["status"] == ["feasible", "feasible"]


def test_a_duration_of_zero_is_invalid_without_a_word_of_numpy(tmp_path):
    study = planar_study(tmp_path, "vary: {motion.duration: [-1, 0, 1.0e-100, 0.5]}")
    with np.errstate(all="raise"):
        assert compare(study, 4) == {"invalid": 3, "feasible": 1}

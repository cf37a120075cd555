"""Rows of a study: what `mrts.scale` says of the files of each variant, and a reason where there is no answer."""

import pytest
from shipped_cells import shipped
from study_files import planar_study

import mrts
from mrts.studies.variants import column_types, solve_one_by_one, solve_variants

SAME = 1e-9
"""Share by which answers from the same numbers may differ: matrices are rounded once more on the way through a file."""


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


def test_questions_of_a_study_are_those_of_scale(tmp_path):
    text = "vary: {object.mass: [0.4, 0.8]}\nreserve: 0.1\nbetween: 0.001"
    study = planar_study(tmp_path, text)
    for row in rows_of(solve_variants(study, 0, 2)):
        result = scaled(study, row["variant"], tmp_path / str(row["variant"]), reserve=0.1, between=0.001)
        assert row["c2_upper"] == pytest.approx(result.range.upper.c2, rel=SAME)


def test_an_uncertain_load_is_asked_about(tmp_path, planar_cell, lift):
    cell = shipped("planar_dual_arm")
    cell["object"]["variation"] = {"mass": [0.5, 1.5]}
    study = planar_study(tmp_path, "vary:\n  object.variation.mass[1]: [1.5, 3]", cell=cell)
    expected = [mrts.scale(planar_cell.with_variation(mass=(0.5, most)), lift, between=None) for most in (1.5, 3.0)]
    found = solve_variants(study, 0, 2)
    assert found["c2_upper"] == pytest.approx([result.range.upper.c2 for result in expected], rel=SAME)


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

"""Named outcomes: infeasible, empty, unbounded, minimum speed; selection; certificates; fixed distributions."""

import re
import shutil

import numpy as np
import pytest
import yaml
from conftest import DATA
from given_ranges import ranges_of
from shipped_cells import still_motion

import mrts
from mrts.limits.rows import LimitRows, RowName
from mrts.program.infeasibility import separation
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import SampleStatus
from mrts.scaling.range import intersect

pytestmark = pytest.mark.quick


def certificate(problem, conflict):
    """The conflict's multipliers as a vector over the problem's rows, which are divided by their units."""
    y = np.zeros(len(problem.names))
    for row, multiplier in zip(conflict.rows, conflict.multipliers, strict=True):
        assert (multiplier > 0) == (row.side == "upper")
        index = problem.names.index(row.name)
        y[index] = multiplier * problem.unit[index]
    return y


def test_an_infeasible_motion_is_explained_by_a_certificate(planar_cell, lift):
    heavy = planar_cell.with_mass(60.0)
    result = mrts.scale(heavy, lift)
    assert result.status is mrts.ScalingStatus.INFEASIBLE
    assert result.trajectory is None
    assert result.torque == {}
    problem = build_sample_problem(motion_rows(heavy, result.motion))
    conflicts = result.range.samples.conflicts
    assert conflicts
    for conflict in conflicts:
        assert result.range.samples.status[conflict.sample] is SampleStatus.INFEASIBLE
        y = certificate(problem, conflict)
        value, error = separation(problem, conflict.sample, y)
        assert error <= 1e-8
        # the certificate's own margin is the widening that the message states
        assert -value == pytest.approx(conflict.widening, rel=1e-6)
        assert conflict.widening > 0.01
    assert "these limits conflict" in result.summary()
    assert "elbow" in result.summary()


@pytest.mark.parametrize("k", [1e-9, 1e9])
@pytest.mark.parametrize("formulation", ["wrench", "torque"])
def test_units_do_not_matter(planar_cell, lift, k, formulation, tmp_path):
    """All masses, inertias and limits times k: the same range, and limits kept to the same share of themselves."""
    for path in DATA.iterdir():
        shutil.copy(path, tmp_path / path.name)
    urdf = (tmp_path / "planar_arm.urdf").read_text()
    keys = re.compile(r'(value|ixx|iyy|izz)="([^"]+)"')
    (tmp_path / "planar_arm.urdf").write_text(keys.sub(lambda m: f'{m[1]}="{float(m[2]) * k!r}"', urdf))
    cell = yaml.safe_load((tmp_path / "cell.yaml").read_text())
    cell["object"]["mass"] *= k
    cell["object"]["inertia"] = [value * k for value in cell["object"]["inertia"]]
    for robot in cell["robots"]:
        robot["torque"] = [value * k for value in robot["torque"]]
        for side in robot["wrench"]:
            robot["wrench"][side] = [value and value * k for value in robot["wrench"][side]]
    (tmp_path / "cell.yaml").write_text(yaml.safe_dump(cell))
    scaled = mrts.load_cell(tmp_path / "cell.yaml")
    result = mrts.scale(scaled, lift, formulation=formulation)
    assert result.range.upper.c2 == pytest.approx(mrts.scale(planar_cell, lift).range.upper.c2, rel=1e-9)
    assert result.residuals().limits < 1e-8
    heavy = mrts.scale(scaled.with_mass(60 * k), lift, formulation=formulation).range
    assert heavy.status is mrts.ScalingStatus.INFEASIBLE
    expected = mrts.scale(planar_cell.with_mass(60), lift).range.samples.conflicts
    assert [c.widening for c in heavy.samples.conflicts] == pytest.approx([c.widening for c in expected], rel=1e-6)


def test_an_empty_intersection_names_both_samples():
    found = intersect(ranges_of([0, 2, 0], [5, 5, 1]))
    assert found.status is mrts.ScalingStatus.EMPTY
    assert (found.lower.time, found.upper.time) == (1.0, 2.0)
    assert "t = 1 s" in found.explain()
    assert "t = 2 s" in found.explain()


def test_a_range_that_rounding_turned_inside_out_is_a_point():
    found = intersect(ranges_of([0, 1 + 1e-12], [1, 3]))
    assert found.status is mrts.ScalingStatus.FEASIBLE
    assert found.lower.c2 == found.upper.c2 == 1.0


def test_at_rest_nothing_limits_the_speed(planar_cell, lift):
    still = still_motion(lift.position[0])
    result = mrts.scale(planar_cell, still)
    assert result.status is mrts.ScalingStatus.UNBOUNDED
    assert result.trajectory.c2 == 1.0
    assert result.to_json()["c2"] == {"lower": 0.0, "upper": None}


@pytest.mark.parametrize("options", [{}, {"formulation": "torque"}, {"solver": "qpsol:qpoases"}])
def test_where_nothing_may_move_the_range_is_standing_still(planar_cell, lift, options):
    def held(cell, motion):
        speed = np.linalg.norm(motion.object.twist, axis=1)[:, None]
        return LimitRows.of(cell, [RowName("hold", "left")], np.zeros(1), np.zeros(1), speed=speed)

    with pytest.raises(mrts.SelectionError, match="only hold still") as caught:
        mrts.scale(planar_cell, lift, limits=[held], **options)
    assert (caught.value.result.range.lower.c2, caught.value.result.range.upper.c2) == (0.0, 0.0)


@pytest.mark.parametrize("c2", [3.1, 0.0, -1.0, float("nan"), float("inf"), 10**400])
def test_a_value_outside_the_range_is_refused_with_the_range(planar_cell, lift, c2):
    with pytest.raises(mrts.SelectionError, match=r"\[0, 3\.0618") as caught:
        mrts.scale(planar_cell, lift, c2)
    assert caught.value.result.range.upper.c2 == pytest.approx(3.0618125)


def test_shares_and_internal_wrench_of_a_fixed_distribution(planar_cell, lift):
    equal = mrts.scale(planar_cell, lift, sharing=mrts.LoadSharing())
    assert np.max(np.abs(equal.trajectory.internal_wrench)) < 1e-12
    np.testing.assert_allclose(equal.wrench["left"], equal.wrench["right"], atol=1e-12)
    # squeeze of 1.5 N: opposite x forces balance, both arms at the same height
    squeeze = np.array([1.5, 0, 0, -1.5, 0, 0])
    pressed = mrts.scale(planar_cell, lift, 1.0, sharing=mrts.LoadSharing(internal_wrench=squeeze))
    np.testing.assert_allclose(pressed.trajectory.internal_wrench, np.broadcast_to(squeeze, (101, 6)), atol=1e-12)
    uneven = mrts.scale(planar_cell.without_wrench_limits(), lift, 1.0, sharing=mrts.LoadSharing(np.array([0.7, 0.3])))
    np.testing.assert_allclose(uneven.wrench["left"][:, 1] * 3, uneven.wrench["right"][:, 1] * 7, atol=1e-10)
    assert uneven.residuals().object < 1e-10


@pytest.mark.parametrize(
    ("sharing", "match"),
    [
        (mrts.LoadSharing(np.array([0.5, 0.6])), "sum to 1"),
        (mrts.LoadSharing(np.array([1.5, -0.5])), ">= 0"),
        (mrts.LoadSharing(np.array([1.0])), "2 finite numbers"),
        (mrts.LoadSharing(internal_wrench=np.array([1.0, 0, 0, 0, 0, 0])), "must not move the object"),
        (mrts.LoadSharing(internal_wrench=np.zeros(5)), "Shape"),
    ],
)
def test_a_wrong_fixed_distribution_is_refused(planar_cell, lift, sharing, match):
    with pytest.raises(mrts.InputError, match=match):
        mrts.scale(planar_cell, lift, sharing=sharing)

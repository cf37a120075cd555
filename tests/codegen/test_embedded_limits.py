"""Limits in exported libraries: velocities, limits given in Python, limits of zero; what cannot go in is refused."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from exported_library import answers, changed_cell, run

import mrts
from mrts.cell.generation import export_to
from mrts.cli import main
from mrts.limits.rows import LimitRows, RowName
from mrts.output.embedded_limits import embedded_limits
from mrts.output.embedded_test_vectors import make_vectors

LIFT = DATA / "lift.yaml"

SAME = 1e-9
"""Of c² by the library and by Python, relative: both solve to rounding."""

HORIZON = """
#include <stdio.h>
#include "planar_dual_arm.h"
#include "planar_dual_arm_vectors.h"
int main(void) {
    static planar_dual_arm_workspace w;
    planar_dual_arm_settings s;
    planar_dual_arm_range r, least = {0};
    planar_dual_arm_horizon h;
    planar_dual_arm_default_settings(&s);
    CHANGE
    planar_dual_arm_horizon_start(&h);
    for (int k = 0; k < PLANAR_DUAL_ARM_PATH_SAMPLES; ++k) {
        planar_dual_arm_CALL;
        planar_dual_arm_horizon_add(&h, &r);
        if (h.upper_sample == k) least = r;
    }
    printf("%d %.17g %ld %s", (int)h.status, h.upper, h.upper_sample, planar_dual_arm_row_text(least.upper_rows[0]));
    return 0;
}
"""

FREE = "range_of_sample(&planar_dual_arm_vectors[k].sample, &s, &r, &w)"
EVEN = "equal_share_range(&planar_dual_arm_vectors[k].sample, &s, &r, &w)"
FOR_ALL = (
    "guaranteed_range(&planar_dual_arm_vectors[k].sample, &s, planar_dual_arm_load_corners, "
    "PLANAR_DUAL_ARM_CORNERS, &r, 0, 0, &w)"
)


def exported(path, place):
    """Its library, whose own tests pass."""
    folder = place / "library"
    assert main(["export", str(path), "-o", str(folder), "--motion", str(LIFT)]) == 0
    assert "0 mismatches" in run("make", "test", cwd=folder)
    return folder


def horizon(folder, place, call=FREE, change=""):
    """Status, upper end, its sample and row, over the motion of the vectors."""
    said = answers(folder, HORIZON.replace("CALL", call).replace("CHANGE", change), place)
    status, upper, sample, row = said.split(maxsplit=3)
    return int(status), float(upper), int(sample), row


def slow_object(cell):
    cell["object"]["velocity"] = {"linear": 0.8}


def test_velocity_limits_bound_every_range(tmp_path):
    path = changed_cell(tmp_path, slow_object)
    folder = exported(path, tmp_path)
    cell, motion = mrts.load_cell(path), mrts.load_motion(LIFT)
    free = mrts.scale(cell, motion).range.upper
    assert str(free.rows[0].name) == "object/linear velocity"
    even = mrts.scale(cell, motion, sharing=mrts.LoadSharing()).range.upper
    for call, wanted in ((FREE, free), (FOR_ALL, free), (EVEN, even)):
        status, upper, sample, row = horizon(folder, tmp_path, call)
        assert (status, sample, row) == (0, wanted.sample, "object/linear velocity")
        assert upper == pytest.approx(wanted.c2, rel=SAME)
    unlimited = mrts.scale(cell.without_velocity_limits(), motion).range.upper
    lifted = "for (int i = 0; i < PLANAR_DUAL_ARM_VELOCITIES; ++i) s.velocity[i] = PLANAR_DUAL_ARM_UNLIMITED;"
    _, upper, _, row = horizon(folder, tmp_path, change=lifted)
    assert upper == pytest.approx(unlimited.c2, rel=SAME)
    assert "velocity" not in row
    _, upper, _, row = horizon(folder, tmp_path, change="s.velocity[1] = 0.01;")
    assert upper < free.c2
    assert row == "left/elbow velocity"


def test_torques_beyond_a_velocity_limit_are_no_answer(tmp_path):
    folder = exported(changed_cell(tmp_path, slow_object), tmp_path)
    program = HORIZON.replace("CALL", FREE).replace("CHANGE", "planar_dual_arm_real t[6], f[6];")
    sample = "&planar_dual_arm_vectors[h.upper_sample].sample"
    asked = "".join(
        f'printf(" %d", (int)planar_dual_arm_torques({sample}, &s, {share} * h.upper, t, f, &w));'
        for share in (0.5, 1, 1.001)
    )
    assert answers(folder, program.replace("    return 0;", asked + " return 0;"), tmp_path).endswith(" 0 0 2")


def supply(_cell, _motion):
    """Two torques together may not exceed a limit, such as that of a supply that two motors share."""
    matrix = np.zeros((1, 6))
    matrix[0, [0, 4]] = 1.0
    name = mrts.RowName("supply", "left shoulder and right", "elbow", "N m")
    return LimitRows(
        names=(name,),
        lower=np.array([-150.0]),
        upper=np.array([np.inf]),
        torque_matrix=matrix,
        wrench_matrix=np.zeros((1, 6)),
    )


SUPPLY = "left shoulder and right/elbow supply"


def test_a_limit_given_to_a_cell_reaches_the_library_and_binds(tmp_path):
    cell = mrts.load_cell(DATA / "cell.yaml").with_limits(supply)
    motion = mrts.follow_object(cell, mrts.load_motion(LIFT))
    wanted = mrts.scale(cell, motion).range.upper
    assert SUPPLY in {str(row.name) for row in wanted.rows}
    folder, vectors = tmp_path / "library", make_vectors(cell, motion)
    given = {"limits": embedded_limits(cell), "vectors": vectors, "path_samples": motion.samples}
    export_to(DATA / "cell.yaml", folder, **given, precision="double", parts=())
    assert "0 mismatches" in run("make", "test", cwd=folder)
    status, upper, sample, row = horizon(folder, tmp_path)
    assert (status, sample, row) == (0, wanted.sample, SUPPLY)
    assert upper == pytest.approx(wanted.c2, rel=SAME)
    _, upper, _, row = horizon(folder, tmp_path, change="s.lower[PLANAR_DUAL_ARM_ROWS - 1] = -1000;")
    assert upper > wanted.c2
    assert row != SUPPLY


def zero_wrench(cell):
    for robot in cell["robots"]:
        robot["wrench"] = {"lower": [None, None, 0], "upper": [2, None, 0]}


def test_a_limit_of_zero_means_the_same_in_both(tmp_path):
    path = changed_cell(tmp_path, zero_wrench)
    wanted = mrts.scale(mrts.load_cell(path), mrts.load_motion(LIFT)).range.upper
    status, upper, sample, _ = horizon(exported(path, tmp_path), tmp_path)
    assert (status, sample) == (0, wanted.sample)
    assert upper == pytest.approx(wanted.c2, rel=SAME)


def friction(cell, motion):
    """A torque that a motor loses with its speed."""
    rows = supply(cell, motion)
    return replace(rows, names=(RowName("friction", "left", "shoulder", "N m"),), speed=motion.dq[:, :1])


def soft_start(cell, motion):
    """A torque that may be the smaller the faster the first joint ever is."""
    return replace(supply(cell, motion), lower=np.array([-150.0 / (1 + np.max(np.abs(motion.dq[:, 0])))]))


@pytest.mark.parametrize(("limit", "what"), [(friction, "speed"), (soft_start, "motion")])
def test_a_limit_that_a_library_cannot_compute_is_refused(limit, what, planar_cell):
    with pytest.raises(mrts.InputError, match=f"limit '{limit.__name__}': depends on the {what}"):
        embedded_limits(planar_cell.with_limits(limit))


def test_rows_that_do_not_fit_are_refused_by_the_name_of_their_limit(planar_cell):
    def narrow(_cell, _motion):
        return replace(supply(None, None), torque_matrix=np.zeros((1, 5)), wrench_matrix=np.zeros((1, 7)))

    with pytest.raises(mrts.InputError, match="limit 'narrow': torque_matrix"):
        embedded_limits(planar_cell.with_limits(narrow))


def hands(cell):
    """A pad that presses toward the middle and a gripper, both tight, beside no limits of wrenches."""
    kinds = {
        "pad": {"friction": 0.9, "normal": [1, 0, 0], "half_width": [0.2], "force": [-0.0, 60]},
        "gripper": {"force": 12, "friction": 0.8, "half_width": [0.3], "axis": [1, 0, 0]},
    }
    for robot, (kind, values) in zip(cell["robots"], kinds.items(), strict=True):
        robot["contact"] = [{kind: values}]
        del robot["wrench"]


@pytest.mark.parametrize("precision", ["double", "float"])
def test_hands_reach_the_library_and_bind(precision, tmp_path):
    path = changed_cell(tmp_path, hands)
    wanted = mrts.scale(mrts.load_cell(path), mrts.load_motion(LIFT)).range.upper
    names = {str(row.name) for row in wanted.rows}
    assert any("/pad" in name or "/gripper" in name for name in names)
    folder = tmp_path / "library"
    options = ["--motion", str(LIFT), "--precision", precision]
    assert main(["export", str(path), "-o", str(folder), *options]) == 0
    assert "0 mismatches" in run("make", "test", cwd=folder)
    if precision == "double":
        status, upper, sample, row = horizon(folder, tmp_path)
        assert (status, sample) == (0, wanted.sample)
        assert upper == pytest.approx(wanted.c2, rel=SAME)
        assert row in names
    told = (folder / "README.md").read_text()
    assert "planar_dual_arm_real turned[" in (folder / "include" / "planar_dual_arm.h").read_text()
    assert str(answers(folder, SIZE, tmp_path)) in told


SIZE = """
#include <stdio.h>
#include "planar_dual_arm.h"
int main(void) {
    printf("%u", (unsigned)sizeof(planar_dual_arm_workspace));
    return 0;
}
"""

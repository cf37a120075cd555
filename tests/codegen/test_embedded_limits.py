"""Limits in exported libraries: velocities, limits given in Python, hands; what cannot go in is refused."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from exported_library import run
from loaded_library import LoadedLibrary
from shipped_cells import changed_cell

import mrts
from mrts.cell.generation import export_to
from mrts.cli import main
from mrts.limits.rows import LimitRows, RowName
from mrts.output.embedded_limits import embedded_limits
from mrts.output.embedded_test_vectors import make_vectors

LIFT = DATA / "lift.yaml"

SAME = 1e-9
"""Of c² by the library and by Python, relative: both solve to rounding."""


def exported(path, place):
    """Its library, whose own tests pass."""
    folder = place / "library"
    assert main(["export", str(path), "-o", str(folder), "--motion", str(LIFT)]) == 0
    assert "0 mismatches" in run("make", "test", cwd=folder)
    return folder


def assert_binds_as(wanted, found, row=None):
    """Status, upper end, its sample and row, over the motion."""
    assert (found[0], found[2]) == (0, wanted.sample)
    assert found[1] == pytest.approx(wanted.c2, rel=SAME)
    assert found[3] in ({str(each.name) for each in wanted.rows} if row is None else {row})


def test_velocity_limits_bound_every_range(tmp_path):
    path = changed_cell(tmp_path, lambda cell: cell["object"].update(velocity={"linear": 0.8}))
    library, cell = LoadedLibrary(exported(path, tmp_path), tmp_path), mrts.load_cell(path)
    motion = mrts.follow_object(cell, mrts.load_motion(LIFT))
    free = mrts.scale(cell, motion).range.upper
    even = mrts.scale(cell, motion, sharing=mrts.LoadSharing()).range.upper
    for call, wanted in (("range_of_sample", free), ("guaranteed_range", free), ("equal_share_range", even)):
        assert_binds_as(wanted, library.horizon(motion, call), "object/linear velocity")
    fastest = library.sample(motion, free.sample)
    assert [library.torques(fastest, share * free.c2)[0] for share in (0.5, 1, 1.001)] == [0, 0, 2]
    library.settings.velocity[1] = 0.01
    _, upper, _, row, _ = library.horizon(motion)
    assert upper < free.c2
    assert row == "left/elbow velocity"
    library.settings.velocity[:] = [1e300] * len(library.settings.velocity)
    found = library.horizon(motion)
    assert_binds_as(mrts.scale(cell.without_velocity_limits(), motion).range.upper, found)
    assert "velocity" not in found[3]


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
    export_to(DATA / "cell.yaml", folder, **given, precision="double")
    assert "0 mismatches" in run("make", "test", cwd=folder)
    library = LoadedLibrary(folder, tmp_path)
    assert_binds_as(wanted, library.horizon(motion), SUPPLY)
    library.settings.lower[-1] = -1000
    _, upper, _, row, _ = library.horizon(motion)
    assert upper > wanted.c2
    assert row != SUPPLY


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


def hands(cell):
    """A pad that presses toward the middle and a gripper, both tight, beside no limits of wrenches."""
    kinds = {
        "pad": {"friction": 0.9, "normal": [1, 0, 0], "half_width": [0.2], "force": [-0.0, 60]},
        "gripper": {"force": 12, "friction": 0.8, "half_width": [0.3], "axis": [1, 0, 0]},
    }
    for robot, (kind, values) in zip(cell["robots"], kinds.items(), strict=True):
        robot["contact"] = [{kind: values}]
        del robot["wrench"]


def test_hands_reach_the_library_and_bind(tmp_path):
    path = changed_cell(tmp_path, hands)
    folder, cell = exported(path, tmp_path), mrts.load_cell(path)
    motion = mrts.follow_object(cell, mrts.load_motion(LIFT))
    wanted = mrts.scale(cell, motion).range.upper
    assert any("/pad" in str(row.name) or "/gripper" in str(row.name) for row in wanted.rows)
    assert_binds_as(wanted, LoadedLibrary(folder, tmp_path).horizon(motion))
    assert "planar_dual_arm_real turned[" in (folder / "include" / "planar_dual_arm.h").read_text()

"""Limits in exported libraries: all that a cell file may have bind as on the desktop; what cannot go in is refused."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from exported_library import run
from gantries import loop
from loaded_library import LoadedLibrary
from shipped_cells import changed_cell

import mrts
from mrts.cell.generation import export_to
from mrts.cli import main
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import LimitRows, RowName
from mrts.output.embedded_tables import embedded_tables

LIFT = DATA / "lift.yaml"

SAME = 1e-9
"""Of c² by the library and by Python, relative: both solve to rounding."""


def exported_folder(path, place):
    """Its library, whose own tests pass."""
    folder = place / "library"
    assert main(["export", str(path), "-o", str(folder), "--motion", str(LIFT)]) == 0
    assert "0 mismatches" in run("make", "test", cwd=folder)
    return folder


def exported_with(path, cell, motion, place, precision="double"):
    """The library of a cell and a motion that no file gives, whose own tests pass."""
    export_to(path, place / "library", tables=embedded_tables(cell, motion), precision=precision)
    assert "0 mismatches" in run("make", "test", cwd=place / "library")
    return place / "library"


def assert_binds_as(wanted, found, row=None):
    """Status, upper end, its sample and row, over the motion."""
    assert (found[0], found[2]) == (0, wanted.sample)
    assert found[1] == pytest.approx(wanted.c2, rel=SAME)
    assert found[3] in ({str(each.name) for each in wanted.rows} if row is None else {row})


def test_velocity_limits_bound_every_range(tmp_path):
    path = changed_cell(tmp_path, lambda cell: cell["object"].update(velocity={"linear": 0.8}))
    library, cell = LoadedLibrary(exported_folder(path, tmp_path), tmp_path), mrts.load_cell(path)
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


def supply(cell, _motion):
    """Two torques together may not exceed a limit, such as that of a supply that two motors share."""
    matrix = np.zeros((1, 6))
    matrix[0, [0, 4]] = 1.0
    name = mrts.RowName("supply", "left shoulder and right", "elbow", "N m")
    return LimitRows.of(cell, [name], np.array([-150.0]), np.array([np.inf]), torque_matrix=matrix)


SUPPLY = "left shoulder and right/elbow supply"


def test_a_limit_given_to_a_cell_reaches_the_library_and_binds(tmp_path):
    cell = mrts.load_cell(DATA / "cell.yaml").with_limits(supply)
    motion = mrts.follow_object(cell, mrts.load_motion(LIFT))
    wanted = mrts.scale(cell, motion).range.upper
    assert SUPPLY in {str(row.name) for row in wanted.rows}
    library = LoadedLibrary(exported_with(DATA / "cell.yaml", cell, motion, tmp_path), tmp_path)
    assert_binds_as(wanted, library.horizon(motion), SUPPLY)
    library.settings.lower[-1] = -1000
    _, upper, _, row, _ = library.horizon(motion)
    assert upper > wanted.c2
    assert row != SUPPLY


def friction(cell, motion):
    """A torque that a motor loses with its speed."""
    rows = supply(cell, motion)
    names = (RowName("friction", "left", "shoulder", "N m"),)
    return replace(rows, limits=replace(rows.limits, names=names), speed=motion.dq[:, :1])


def soft_start(cell, motion):
    """A torque that may be the smaller the faster the first joint ever is."""
    rows, lower = supply(cell, motion), np.array([-150.0 / (1 + np.max(np.abs(motion.dq[:, 0])))])
    return replace(rows, limits=replace(rows.limits, lower=lower))


@pytest.mark.parametrize(("limit", "what"), [(friction, "speed"), (soft_start, "motion")])
def test_a_limit_that_a_library_cannot_compute_is_refused(limit, what, planar_cell, lift):
    with pytest.raises(mrts.InputError, match=f"limit '{limit.__name__}': depends on the {what}"):
        embedded_tables(planar_cell.with_limits(limit), lift)


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
    folder, cell = exported_folder(path, tmp_path), mrts.load_cell(path)
    motion = mrts.follow_object(cell, mrts.load_motion(LIFT))
    wanted = mrts.scale(cell, motion).range.upper
    assert any("/pad" in str(row.name) or "/gripper" in str(row.name) for row in wanted.rows)
    assert_binds_as(wanted, LoadedLibrary(folder, tmp_path).horizon(motion))
    assert "planar_dual_arm_real turned[" in (folder / "include" / "planar_dual_arm.h").read_text()


OK, INFEASIBLE, BAD_ARGUMENT = 0, 2, 5
WARNINGS = "-std=c99 -O2 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Werror"
UNLIMITED = 1e300
FIELDS = ("acceleration_lower", "acceleration_upper", "object_acceleration", "point_speed", "point_acceleration",
          "friction", "tilt")  # fmt: skip
"""Of its settings."""


def all_kinds(cell):
    """A limit of every kind."""
    for robot in cell["robots"]:
        robot["acceleration"] = {"lower": [-40.0, -30.0, -50.0], "upper": [35.0, 45.0, 55.0]}
        robot["frames"] = [{"link": "forearm", "point": [0.1, 0.05, 0], "speed": 1.1, "acceleration": 6.0}]
    cell["object"]["acceleration"] = {"linear": 5.0, "angular": 3.0}
    cell["object"]["frames"] = [{"name": "corner", "point": [0.3, 0.05, 0], "speed": 1.3, "acceleration": 7.0}]
    tray = {"at": [0.2, 0.04, 0], "normal": [0, 1, 0]}
    cell["object"]["carries"] = [{"name": "cup", **tray, "friction": 0.4, "half_width": [0.03, 0.04], "height": 0.12}]


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """The cell, its motion, and its library of doubles, whose vectors pass in double and float."""
    place = tmp_path_factory.mktemp("motions")
    path = changed_cell(place, all_kinds)
    for precision in ("float", "double"):
        given = "-o", str(place / precision), "--precision", precision, "--motion", str(LIFT)
        assert main(["export", str(path), *given]) == 0
        assert "0 mismatches" in run("make", "test", f"CFLAGS={WARNINGS}", cwd=place / precision)
    cell = mrts.load_cell(path)
    return cell, mrts.follow_object(cell, mrts.load_motion(LIFT)), place


@pytest.fixture
def library(exported):
    """With the settings of the cell file."""
    _, _, place = exported
    return LoadedLibrary(place / "double", place)


@pytest.mark.parametrize(
    ("field", "place", "limit", "bound", "row"),
    [
        ("acceleration_upper", 0, 3.0, lambda motion: motion.ddq[:, 0] / 3, "left/shoulder acceleration"),
        ("acceleration_lower", 4, -3.0, lambda motion: -motion.ddq[:, 4] / 3, "right/elbow acceleration"),
        ("object_acceleration", 0, 2.0, lambda motion: np.linalg.norm(motion.object.acceleration[:, :3], axis=1) / 2,
         "object/linear acceleration"),
    ],
)  # fmt: skip
def test_a_limit_set_at_run_time_binds_where_it_is_reached(field, place, limit, bound, row, exported, library):
    _, motion, _ = exported
    for name in FIELDS:
        array = getattr(library.settings, name)
        array[:] = [np.copysign(UNLIMITED, array[0])] * len(array)
    getattr(library.settings, field)[place] = limit
    status, upper, sample, named, _ = library.horizon(motion)
    share = bound(motion)
    assert (status, sample, named) == (OK, np.argmax(share), row)
    assert upper == pytest.approx(1 / np.max(share), rel=SAME)


@pytest.mark.parametrize(
    ("field", "place", "limit", "change"),
    [
        ("point_speed", 0, 0.5, lambda cell: cell["robots"][0]["frames"][0].update(speed=0.5)),
        ("point_acceleration", 1, 2.0, lambda cell: cell["robots"][1]["frames"][0].update(acceleration=2.0)),
        ("point_speed", 2, 0.7, lambda cell: cell["object"]["frames"][0].update(speed=0.7)),
        ("point_acceleration", 2, 2.0, lambda cell: cell["object"]["frames"][0].update(acceleration=2.0)),
    ],
)
def test_points_bind_as_on_the_desktop(field, place, limit, change, exported, library, tmp_path):
    _, motion, _ = exported
    cell = mrts.load_cell(changed_cell(tmp_path, lambda cell: (all_kinds(cell), change(cell))))
    wanted = mrts.scale(cell, motion).range.upper
    getattr(library.settings, field)[place] = limit
    for call in ("range_of_sample", "guaranteed_range", "equal_share_range"):
        assert_binds_as(wanted, library.horizon(motion, call))
    fastest = library.sample(motion, wanted.sample)
    assert [library.torques(fastest, share * wanted.c2)[0] for share in (0.5, 1, 1.001)] == [OK, OK, INFEASIBLE]


def test_limits_that_are_none_are_bad_arguments(exported, library):
    _, motion, _ = exported
    sample = library.sample(motion, 20)
    assert library.range(sample)[0] == OK
    for field in FIELDS:
        array = getattr(library.settings, field)
        kept = array[0]
        for bad in (0.0, -kept, np.nan):
            array[0] = bad
            assert library.call("check_settings", library.settings) == BAD_ARGUMENT
            assert library.range(sample)[0] == library.torques(sample, 1)[0] == BAD_ARGUMENT
        array[0] = kept
    assert library.call("check_settings", library.settings) == OK


RADIUS, TURNING, FRICTION = 0.5, 2.0, 0.5
"""Of a loop [m, rad/s], and of a cup's foot."""


def once_around(cell):
    """The object in a loop, its top toward the middle, joints wherever they are."""
    angle = np.linspace(0.1, 2 * np.pi - 0.1, 41)  # from the lowest point
    turning = np.full(len(angle), TURNING)
    path = loop((angle - angle[0]) / TURNING, np.pi - angle, -turning, 0 * turning, RADIUS)
    q, rest = np.tile(cell.posture, (len(angle), 1)), np.zeros((len(angle), len(cell.posture)))
    return angle, CoordinatedMotion(path, q, rest, rest)


def strong(cell):
    """A cup that only rubs, and arms that stand any loop."""
    for robot in cell["robots"]:
        robot["torque"] = [1e4] * 3
        del robot["wrench"]
    cell["object"]["carries"] = [{"name": "cup", "normal": [0, 1, 0], "friction": FRICTION}]


@pytest.mark.parametrize("precision", ["double", "float"])
def test_a_cup_stays_in_a_loop_from_a_least_speed_on(precision, tmp_path):
    path = changed_cell(tmp_path, strong)
    cell = mrts.load_cell(path)
    angle, motion = once_around(cell)
    assert np.mean(embedded_tables(cell, motion)["VECTOR_ROWS"]["lower"] > 0) > 0.5
    folder = exported_with(path, cell, motion, tmp_path, precision)
    if precision == "float":
        return
    library = LoadedLibrary(folder, tmp_path)
    least = 9.8 / (TURNING**2 * RADIUS) * np.maximum(np.abs(np.sin(angle)) / FRICTION - np.cos(angle), 0)
    samples = [library.sample(motion, index) for index in range(motion.samples)]
    top = len(samples) // 2
    assert [library.torques(samples[top], share * least[top])[0] for share in (0.999, 1)] == [INFEASIBLE, OK]
    library.settings.velocity[7] = 0.5 * TURNING * np.sqrt(least[top])
    assert library.range(samples[top])[0] == INFEASIBLE
    asked = library.Range()
    library.call("range_of_sample", samples[top], library.settings, asked, library.workspace)
    rows = asked.upper_rows[: asked.upper_count]
    named = [library.call("row_text", row).decode() for row in rows]
    assert named == ["object/angular velocity", "object/cup friction"]
    samples[top].acceleration[:3] = [0, 0, 0]
    library.call("range_of_sample", samples[top], library.settings, asked, library.workspace)
    assert (asked.status, asked.upper_count) == (INFEASIBLE, 1)
    assert library.call("row_text", asked.upper_rows[0]) == b"object/cup friction"

"""Joint waypoints without times, and noisy recordings that are smoothed when asked."""

import numpy as np
import pytest
from command_line import mrts_command
from conftest import UR5
from motion_tables import columns_of, write_table
from scipy.interpolate import CubicSpline

import mrts

PASSED_BY = 1e-3
"""Share of a duration by which a spline through every tenth sample of a path is slower or faster (5e-4)."""

NOISE, ALLOWED = 2e-4, 1e-3
"""[rad]; deviation of a recording, and what its splines may be off: 9612 values pass 5 deviations once in 180 tries."""


@pytest.fixture
def waypoints(dual_ur5, exact):
    """Columns of every tenth position, without t."""
    columns = columns_of(dual_ur5, exact["turn", 101][0], ("q",))
    return {name: values[::10] for name, values in columns.items() if name != "t"}


@pytest.mark.quick
def test_rows_without_times_are_timed(dual_ur5, exact, waypoints, tmp_path):
    table = mrts.load_motion(write_table(tmp_path / "way.csv", waypoints))
    q = np.column_stack(list(waypoints.values()))
    way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))])
    assert table.time[-1] == pytest.approx(way[-1], rel=1e-12)
    course = table.of([name.removeprefix("q.") for name in waypoints])[2]
    np.testing.assert_allclose(course(way)[0], q, atol=1e-10)
    given = exact["turn", 101][0]
    for rates in (False, 11.5):
        found, expected = (mrts.retime(dual_ur5, motion, rates=rates) for motion in (table, given))
        assert found.duration == pytest.approx(expected.duration, rel=PASSED_BY)
        assert "untimed" in {warning.code for warning in found.warnings}
        assert found.given.untimed
        assert not expected.given.untimed
    with pytest.raises(mrts.InputError, check=lambda error: error.where == "motion"):
        mrts.scale(dual_ur5, table)
    (tmp_path / "study.yaml").write_text(f"cell: {UR5 / 'cell.yaml'}\nmotion: way.csv\nvary: {{object.mass: [1, 2]}}\n")
    with pytest.raises(mrts.InputError, check=lambda error: error.where == str(tmp_path / "way.csv")):
        mrts.read_study(tmp_path / "study.yaml")


def test_what_is_no_table_of_waypoints_is_refused(waypoints, tmp_path):
    twice = {name: np.insert(values, 4, values[3]) for name, values in waypoints.items()}
    with pytest.raises(mrts.InputError, check=lambda error: error.key == "row 5"):
        mrts.load_motion(write_table(tmp_path / "twice.csv", twice))
    rates = waypoints | {f"d{name}": values for name, values in waypoints.items()}
    bare = {name.removeprefix("q."): values for name, values in waypoints.items()}  # who knows what they are
    for columns, rule in (
        (rates, "a column 't' in s is needed"),
        (bare, "a column 't' in s is needed"),
        (waypoints | {"time": np.arange(11.0)}, "unknown column 'time'"),
    ):
        with pytest.raises(mrts.InputError, match=rule):
            mrts.load_motion(write_table(tmp_path / "wrong.csv", columns))


@pytest.fixture
def recording(dual_ur5, exact):
    """Truth at many times, and the same with noise."""
    given = exact["turn", 101][0]
    time = np.linspace(0, given.object.time[-1], 801)
    truth = CubicSpline(given.object.time, given.q, bc_type="clamped")
    noise = NOISE * np.random.default_rng(5).standard_normal((801, given.q.shape[1]))
    names = [f"q.{name}" for name in dual_ur5.joint_names]
    return truth, time, {"t": time} | dict(zip(names, (truth(time) + noise).T, strict=True))


@pytest.mark.quick
def test_a_noisy_recording_is_smoothed_within_what_is_allowed(dual_ur5, exact, recording, tmp_path):
    truth, time, columns = recording
    path = write_table(tmp_path / "noisy.csv", columns)
    with pytest.raises(mrts.MotionError, match="most of it is noise"):
        mrts.scale(dual_ur5, mrts.load_motion(path))
    table = mrts.load_motion(path, smooth=ALLOWED)
    _, (q, dq, _), _, _ = table.of(dual_ur5.joint_names)
    off = np.abs(q - np.column_stack(list(columns.values())[1:]))
    assert np.max(off) <= ALLOWED
    assert np.sqrt(np.mean((q - truth(time)) ** 2)) < NOISE / 4
    np.testing.assert_allclose(dq[[0, -1]], 0.0, atol=1e-9)
    (remark,) = [remark for remark in table.remarks if remark.code == "smoothed"]
    assert f"{np.max(off):.2g}" in remark.text
    found = mrts.scale(dual_ur5, table)
    assert remark in found.warnings
    assert found.range.upper.c2 == pytest.approx(exact["turn", 101][1], rel=0.01)


def test_smoothing_that_cannot_be_is_refused(recording, tmp_path):
    path = write_table(tmp_path / "noisy.csv", recording[2])
    few = write_table(tmp_path / "few.csv", {name: values[:20] for name, values in recording[2].items()})
    with pytest.raises(mrts.InputError, match="needs 21 rows"):
        mrts.load_motion(few, smooth=ALLOWED)
    for wrong in (1e-5, 0, -1.0, 1.0, float("nan"), "much"):
        with pytest.raises(mrts.InputError, check=lambda error: error.where == "smooth"):
            mrts.load_motion(path, smooth=wrong)
    with pytest.raises(mrts.InputError, match="motion of the object"):
        mrts.load_motion(UR5 / "lift_and_turn.yaml", smooth=ALLOWED)


@pytest.mark.quick
def test_the_command_line_smooths(recording, tmp_path):
    cell, noisy = UR5 / "cell.yaml", write_table(tmp_path / "noisy.csv", recording[2])
    assert mrts_command("scale", cell, noisy, "-q", "--smooth", "1e-3").returncode == 0
    refused = mrts_command("scale", cell, noisy, "-q", "--smooth", "1e-5")
    assert refused.returncode == 2
    assert "--smooth" in refused.stderr


def test_a_recording_that_starts_and_ends_in_motion_stays_so(dual_ur5, recording, tmp_path):
    truth, time, columns = recording
    path = write_table(tmp_path / "part.csv", {name: values[200:600] for name, values in columns.items()})
    table = mrts.load_motion(path, smooth=ALLOWED)
    found = table.of(dual_ur5.joint_names)[1][1]
    rates = truth(time[200:600], 1)
    np.testing.assert_allclose(found[[0, -1]], rates[[0, -1]], atol=0.1 * np.max(np.abs(rates)))
    assert np.sqrt(np.mean((found - rates) ** 2)) < 0.02 * np.max(np.abs(rates))

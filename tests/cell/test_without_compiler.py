"""Without a C compiler everything but the compiling of an export works, and gives the same answers."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from conftest import DATA
from gantries import along_x, gantries
from mrts.reachability.speed_kernel import KernelWithoutCompiler, speed_kernel
from mrts_codegen import generate

import mrts
from mrts.cell import generation
from mrts.kernel.programs import INFEASIBLE, OPTIMAL, default_programs
from mrts.reachability import fastest_profile, speed_regions

SAMPLES = 21

TORQUES = 1e-6
"""Of a limit: two solvers of one strictly convex program, each right to 1e-9."""

SCRIPT = """
import json, sys
import mrts
from mrts.reachability.speed_kernel import KernelWithoutCompiler, speed_kernel

assert isinstance(speed_kernel(), KernelWithoutCompiler)
cell, motion = mrts.load_cell(sys.argv[1]), mrts.load_motion(sys.argv[2])
assert cell.functions.backend == "vm"
result, timed = mrts.scale(cell, motion), mrts.retime(cell, motion)
print(json.dumps([result.range.upper.c2, result.torque["left"].tolist(), timed.duration, timed.summary()]))
"""


@pytest.mark.parametrize(("name", "motion"), [("planar_dual_arm", "lift"), ("dual_ur5", "lift_and_turn")])
def test_a_machine_without_a_compiler_gives_the_same_answers(name, motion, planar_cell, dual_ur5, tmp_path):
    cell = {"planar_dual_arm": planar_cell, "dual_ur5": dual_ur5}[name]
    text = (DATA.parent / name / f"{motion}.yaml").read_text()
    given = tmp_path / "motion.yaml"
    assert text.count("samples: 101") == 1
    given.write_text(text.replace("samples: 101", f"samples: {SAMPLES}"))
    environment = {name: value for name, value in os.environ.items() if name != "CC"} | {"PATH": str(tmp_path)}
    arguments = [sys.executable, "-c", SCRIPT, str(DATA.parent / name / "cell.yaml"), str(given)]
    done = subprocess.run(arguments, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    c2, torque, duration, summary = json.loads(done.stdout)
    result, timed = mrts.scale(cell, mrts.load_motion(given)), mrts.retime(cell, mrts.load_motion(given))
    assert c2 == pytest.approx(result.range.upper.c2, rel=1e-9)
    assert np.max(np.abs(np.array(torque) - result.torque["left"])) <= TORQUES * np.max(cell.robots[0].torque_upper)
    assert duration == pytest.approx(timed.duration, rel=1e-9)
    assert summary == timed.summary()


def test_the_kernel_is_taken_where_there_is_a_compiler():
    assert speed_kernel() is default_programs()


def test_projections_are_those_of_the_kernel():
    rng = np.random.default_rng(8)
    count, rows, unknowns = 40, 12, 5
    A = rng.normal(size=(count, rows, unknowns))
    lower, upper = -rng.uniform(0.1, 1, (count, rows)), rng.uniform(0.1, 1, (count, rows))
    lower[:4, 0], upper[:4, 0] = 100, 101  # further out than the other rows reach
    A[:, 1:4, :3] = np.eye(3)
    lower[:, 1:4], upper[:, 1:4] = -3.0, 3.0
    A[:, 4:6, :3] = 0.0  # so that u and x are bounded
    scale, bound = rng.uniform(0.5, 2, (count, unknowns)), np.full((count, 2), 3.0)
    given = A, lower, upper, scale, (-bound, bound), np.arange(rows - 1, dtype=np.int32)
    number, corners, status = KernelWithoutCompiler.projections(*given)
    other_number, other_corners, other_status = default_programs().projections(*given)
    assert np.all(status == np.where(np.arange(count) < 4, INFEASIBLE, OPTIMAL))
    assert np.all((other_status == OPTIMAL) == (status == OPTIMAL))
    angles = np.linspace(0, 2 * np.pi, 64)
    directions = np.stack([np.cos(angles), np.sin(angles)])
    polygons = [
        np.split(points, np.cumsum(counts)) for counts, points in ((number, corners), (other_number, other_corners))
    ]
    for sample in range(4, count):
        ours, theirs = (polygon[sample] for polygon in polygons)
        assert np.allclose(np.max(ours @ directions, axis=0), np.max(theirs @ directions, axis=0), atol=1e-8)
        following = np.roll(ours, -1, axis=0)
        assert np.sum(ours[:, 0] * following[:, 1] - ours[:, 1] * following[:, 0]) > 0  # counter-clockwise


@pytest.mark.parametrize("kernel", [default_programs, KernelWithoutCompiler])
def test_a_projection_without_area_is_two_corners(kernel):
    """What lies between them on their line bounds nothing, and hides that they bound u along itself."""
    rng = np.random.default_rng(10)
    count, rows, unknowns = 60, 9, 5
    A = rng.normal(size=(count, rows, unknowns))
    lower, upper = -rng.uniform(0.1, 1, (count, rows)), rng.uniform(0.1, 1, (count, rows))
    A[:, 0, :3] = 0.0  # a line in u and x
    A[: count // 3, 0, 3] = 0.0  # along u
    lower[:, 0] = upper[:, 0] = 0.0
    A[:, 1:4, :3] = np.eye(3)
    scale, bound = np.ones((count, unknowns)), np.full((count, 2), 3.0)
    number, corners, status = kernel().projections(A, lower, upper, scale, (-bound, bound))
    assert np.all(status == OPTIMAL)
    assert np.all(number == 2)
    assert np.all(np.abs(np.sum(corners * np.repeat(A[:, 0, 3:], 2, axis=0), axis=1)) < 1e-9)


@pytest.mark.parametrize("limits", [{}, {"velocity": 1.0}, {"velocity": 0.7, "wrench": 12}, {"wrench": 5}])
def test_timings_of_limits_that_do_not_depend_on_the_speed_are_those_of_the_kernel(limits, tmp_path, monkeypatch):
    cell, motion = gantries(tmp_path, **limits), along_x(samples=SAMPLES)
    expected = mrts.retime(cell, motion)
    for module in (speed_regions, fastest_profile):
        monkeypatch.setattr(module, "speed_kernel", KernelWithoutCompiler)
    assert mrts.retime(cell, motion).duration == pytest.approx(expected.duration, rel=1e-9)


@pytest.mark.parametrize("largest", [2.0, 1e15])
def test_speeds_are_those_of_the_kernel(largest):
    rng = np.random.default_rng(9)
    outcomes = set()
    for _ in range(40):
        n = 12
        counts = rng.integers(3, 8, n)
        start = np.concatenate([[0], np.cumsum(counts)])
        planes = np.column_stack([rng.normal(size=(start[-1], 2)), rng.uniform(-0.05, 1, start[-1])])
        step = rng.uniform(0.05, 0.2, n - 1)
        rise = rng.uniform(-0.1, 0.1, n - 1)
        found = []
        for kernel in (default_programs(), KernelWithoutCompiler):
            low, high = np.zeros(n), np.full(n, largest)
            low[-1] = high[-1] = 0.0
            failed = kernel.backward(step, rise, start, planes, low, high)
            x = kernel.forward(step, rise, start, planes, low, high, high[0]) if failed < 0 else np.zeros(n)
            found.append((failed, low, high, x))
        (failed, *arrays), (other, *others) = found
        assert failed == other
        outcomes.add(failed < 0)
        assert np.allclose(arrays, others, rtol=1e-12, atol=1e-12)
    assert outcomes == {True, False}


def test_the_virtual_machine_generates_a_cell_once(monkeypatch, tmp_path):
    real, calls = generate.generate_chains, []

    def counted(cell, stem):
        calls.append(stem)
        return real(cell, stem)

    monkeypatch.setenv("MRTS_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(generate, "generate_chains", counted)
    assert mrts.load_cell(DATA / "cell.yaml", backend="vm").functions.backend == "vm"
    assert len(calls) == 1
    assert generation.generated_in_cache(DATA / "cell.yaml")[1].exists()
    assert len(calls) == 1


def random_polygon(rng, box, cap):
    """Corners counter-clockwise: none, a point, a segment, one that is too short to have a direction, a hull, a box."""
    kind = rng.integers(6)
    if kind == 0:
        return rng.normal(size=(rng.integers(3), 2))
    if kind == 1:
        return np.array([[0.0, 0.0], [1e-170, 1e-170]]) * rng.choice([1e-10, 1.0, 1e170])
    if kind == 2:
        corners = np.array([[-1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-1.0, 1.0]]) * [box, cap]
        return corners * (1 - rng.choice([0.0, 5e-7, 2e-6], size=corners.shape))
    angles = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 12)))
    corners = np.column_stack([np.cos(angles), 1 + np.sin(angles)]) * 10 ** rng.uniform(-6, 3, 2)
    return np.repeat(corners, rng.integers(1, 3, len(corners)), axis=0)


def test_half_planes_are_those_of_the_kernel():
    """Bit for bit, of polygons of any kind, and where u or x does not move."""
    rng, box, near = np.random.default_rng(4), 1e5, 1 - 1e-6
    for _ in range(50):
        cap = np.where(rng.random(20) < 0.1, 0.0, 10 ** rng.uniform(-3, 5, 20))
        polygons = [random_polygon(rng, box, most) for most in cap.tolist()]
        number = np.array([len(polygon) for polygon in polygons], dtype=np.int32)
        unit = np.where(rng.random((20, 2)) < 0.2, np.inf, 10 ** rng.uniform(-6, 6, (20, 2)))
        given = number, np.concatenate(polygons), unit, cap, box, near
        found, expected = default_programs().half_planes(*given), KernelWithoutCompiler.half_planes(*given)
        for name, ours in found._asdict().items():
            np.testing.assert_array_equal(ours, getattr(expected, name), err_msg=name, strict=True)
        assert found.start[-1] == len(found.planes) > 0

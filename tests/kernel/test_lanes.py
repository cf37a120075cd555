"""Samples in lanes: the same bits from registers of any width, the same answers as alone; sines and cosines."""

import ctypes
import platform
import shutil
import subprocess
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np
import pytest
from conftest import DATA, ROOT
from shipped_cells import shipped_motion, sizes_of

import mrts
from mrts.cell.generation import generated_in_cache
from mrts.kernel import programs
from mrts.kernel.binding import bind
from mrts.kernel.c_text import CELL_FILES, PROJECTIONS, cell_source, one_text
from mrts.kernel.cell_library import CellLibrary
from mrts.kernel.compiler import FLAGS
from mrts.kernel.programs import OPTIMAL, projections
from mrts.kernel.tracking import closure_sizes
from mrts.program.motion_rows import MotorTerms, motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import unknown_ends
from mrts.program.torque_distribution import TORQUE_WIDENING
from mrts.timing.result import between_path_samples

C = ROOT / "mrts" / "kernel" / "c"
GCC = shutil.which("gcc") or "gcc"
SAMPLES = 301
"""Two chunks, and a last group that is not full."""

WIDE = ("-mavx2",) if platform.machine() == "x86_64" else ()

ROUNDING = 1e-12
"""Of c², relative: two orders of the same operations."""

HALF_A_UNIT = 2.0**-53
"""In the last place of 1: what rounding leaves of a sine; entries of rotations are added to others of size 1."""

SOLVED = 1e-10
"""Of the largest widening or number of a motion: a linear program of rows that differ by rounding."""

FINAL = 1e-8
"""Of how far a projection reaches, relative and in limits: an edge is final if nothing lies 1e-9 outside."""

ANGLES = """
#include "lanes/lanes.h"
MRTS_LANE_FUNCTION(MRTS_WRENCH_FORM_LANES) { (void)arg, (void)sines, (void)res; }
void angles(long long count, const mrts_lanes *angle, mrts_lanes *sine, mrts_lanes *cosine) {
    for (long long i = 0; i < count; ++i) {
        mrts_lanes both[2];
        mrts_sines(1, angle + i, both);
        sine[i] = both[0];
        cosine[i] = both[1];
    }
}
"""


@pytest.fixture(scope="module", params=["planar_dual_arm", pytest.param("dual_ur5", marks=pytest.mark.slow)])
def answers(request, tmp_path_factory):
    """What a library of a shipped cell, compiled with some flags, finds at some samples, by name, samples first."""
    path, folder = DATA.parent / request.param, tmp_path_factory.mktemp(request.param)
    manifest, generated = generated_in_cache(path / "cell.yaml")
    (folder / "cell.c").write_text(one_text((PROJECTIONS,)) + cell_source(manifest, generated.read_text()))
    cell = mrts.load_cell(path / "cell.yaml")
    motion = mrts.follow_object(cell, mrts.load_motion(shipped_motion(request.param, samples=SAMPLES)))
    plain = motion_rows(cell.without_velocity_limits(), motion)
    rng, units, joints = np.random.default_rng(0), plain.given.limits.units, motion.q.shape
    square, offset = rng.normal(size=(2, SAMPLES, len(units))) * units * 1e-3
    of_motors = {name: rng.normal(size=joints) for name in ("square", "rate", "dry")} | {"speed": None}
    motors = MotorTerms(turning=1e-3 * rng.random(joints) * cell.stacked("torque_upper"), **of_motors)
    more = replace(plain, motors=motors)
    vars(more)["kept"] = replace(plain.given, square=square, offset=offset)
    W = rng.uniform(0.5, 2.0, size=motion.q.shape[1])
    all_c2 = np.repeat(rng.choice([0.5, 1.0, 2.0, 200.0], size=(SAMPLES + 19) // 20), 20)[:SAMPLES]
    problem = build_sample_problem(plain, varying=True)

    def found(library, at):
        count, c2, known = len(at), all_c2[at], {}
        vars(plain.cell)["library"] = library
        for kind, rows in (("plain", plain), ("more", more)):
            ranges, kept = unknown_ends(count, len(units)), (~rows.is_cap).nonzero()[0]
            widening, status = np.zeros(count), np.zeros(count, dtype=np.uint8)
            rows.over_samples("mrts_ranges", [np.full(count, 1e300)], [ranges], (len(units) + 1, kept), samples=at)
            rows.over_samples("mrts_widenings", [c2], [widening, status], (units,), speed=1.0, samples=at)
            known |= {f"{kind} {name}": ranges[name] for name in ("lower", "upper", "effect", "status")}
            known[f"{kind} widening"] = widening
            for weights, W_all in (("diagonal", np.eye(len(W))), ("full", np.diag(W) + 0.1 * np.outer(W, W))):
                torque, wrench = np.zeros((count, library.joints)), np.zeros((count, library.wrenches))
                status, half = np.zeros(count, dtype=np.uint8), np.full(count, 0.5)
                for_all = 1, W_all, TORQUE_WIDENING
                rows.over_samples("mrts_torques", [half], [torque, wrench, status], for_all, speed=0.5**0.5, samples=at)
                known |= {f"{kind} {weights} torque": torque, f"{kind} {weights} status": status}
        of_path = problem.at(at)
        effect = np.max(np.abs(of_path.A), axis=1)
        scale = np.divide(1.0, effect, out=np.zeros_like(effect), where=effect > 0)
        far = np.full((count, 2), 1e5) * (scale[:, -2:] > 0)
        given = of_path.A, of_path.lower, of_path.upper, scale, (np.column_stack([-far[:, 0], 0 * far[:, 1]]), far)
        with patch.object(programs, "program_library", lambda _: library.opened):
            number, corners, known["projected status"] = projections(*given)
        known["reach"] = np.array(reaches(number, corners))
        return known

    def of_all(library):
        """What is found between samples, and of all of them at once."""
        drawn = np.random.default_rng(2)
        part = SimpleNamespace(
            piece=SimpleNamespace(path=motion), x=drawn.random(SAMPLES) + 1, rates=drawn.random((SAMPLES - 1, 2))
        )
        ours = SimpleNamespace(library=library, geometry=cell.geometry, wrench_rows=cell.wrench_rows)
        there = between_path_samples(ours, part, np.arange(SAMPLES - 1))
        closed = closure_sizes(
            library, plain.inputs(None), motion.object.position + 1e-3, cell.geometry, cell.wrench_rows
        )
        of_object = map(partial(getattr, there.object), ("time", "position", "rotation", "twist", "acceleration"))
        return [there.q, there.dq, there.ddq, *of_object, closed]

    def compiled(*flags):
        library = folder / f"lib{len(list(folder.iterdir()))}.so"
        subprocess.run([GCC, *FLAGS, *flags, folder / "cell.c", "-o", library, "-lm"], check=True)
        opened = bind(ctypes.CDLL(str(library)), (*CELL_FILES, PROJECTIONS))
        return CellLibrary(manifest, lambda name: opened if name == "cell" else cell.library.following)

    return compiled, found, of_all


def reaches(number, corners):
    """How far each projection reaches in some directions: two may differ by a corner that is none but for rounding."""
    angle = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    directions = np.array([np.cos(angle), np.sin(angle)])
    return [np.max(polygon @ directions, axis=0) for polygon in np.split(corners, np.cumsum(number)[:-1])]


def test_lanes_give_the_same_bits_whatever_the_registers_and_the_answers_of_samples_alone(answers):
    compiled, found, of_all = answers
    narrow, wide = compiled("-O2"), compiled(*WIDE)
    together = found(narrow, np.arange(SAMPLES))
    for name, value in found(wide, np.arange(SAMPLES)).items():
        np.testing.assert_array_equal(value, together[name], err_msg=name)
    for one, other in zip(of_all(wide), of_all(narrow), strict=True):
        np.testing.assert_array_equal(one, other)
    some = np.arange(0, SAMPLES, 7)
    alone = [found(narrow, np.array([sample])) for sample in some]
    for name, value in together.items():
        single = np.concatenate([one[name] for one in alone])
        tolerance = {"reach": FINAL, "torque": SOLVED, "widening": SOLVED}.get(name.split()[-1], ROUNDING)
        largest = np.max(np.abs(single), where=np.isfinite(single), initial=0)
        np.testing.assert_allclose(value[some], single, rtol=tolerance, atol=tolerance * (1 + largest), err_msg=name)
        if name.endswith(("upper", "torque", "reach")):
            assert np.any(value[some] != single), "the lanes have not been at work"
        if name.endswith(("diagonal status", "full status", "projected status")):
            assert np.all(value == OPTIMAL)
        if name.endswith("widening"):
            assert np.any(value == 0)
            assert np.max(value) > 1e-2


def test_sines_and_cosines_are_those_of_extended_precision(tmp_path):
    (tmp_path / "angles.c").write_text(ANGLES)
    library = tmp_path / "angles.so"
    flags = *FLAGS, f"-I{C}", *sizes_of("planar_dual_arm")
    subprocess.run([GCC, *flags, tmp_path / "angles.c", "-o", library, "-lm"], check=True)
    rng = np.random.default_rng(1)
    near = np.arange(-40, 41)[:, None] * (np.pi / 4) + rng.normal(size=500) * 1e-6
    drawn, special = (rng.uniform(-7, 7, 200_000), rng.uniform(-1e5, 1e5, 100_000)), [0.0, -0.0, 1e-300, 1e5, -1e5, 1e9]
    angle = np.concatenate([*drawn, near.ravel(), special])
    angle = angle[: len(angle) // 4 * 4]
    sine, cosine = np.empty_like(angle), np.empty_like(angle)
    pointers = (ctypes.c_void_p(array.ctypes.data) for array in (angle, sine, cosine))
    ctypes.CDLL(str(library)).angles(ctypes.c_longlong(len(angle) // 4), *pointers)
    for found, exact in ((sine, np.sin(angle.astype(np.longdouble))), (cosine, np.cos(angle.astype(np.longdouble)))):
        assert np.max(np.abs(found - exact)) <= HALF_A_UNIT
    not_numbers = np.array([np.nan, np.inf, 1e9, 0.5])
    ctypes.CDLL(str(library)).angles(
        ctypes.c_longlong(1), *(ctypes.c_void_p(array.ctypes.data) for array in (not_numbers, sine, cosine))
    )
    np.testing.assert_array_equal(np.isnan(sine[:4]), [True, True, False, False])
    assert sine[2] == np.sin(1e9)

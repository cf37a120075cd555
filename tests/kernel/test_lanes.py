"""Samples in lanes: the same bits from registers of any width, the same answers as singly; sines and cosines."""

import ctypes
import shutil
import subprocess
from functools import cache

import numpy as np
import pytest
import yaml
from conftest import DATA, ROOT

import mrts
from mrts.base.manifest import GEOMETRY
from mrts.cell.generation import generated_in_cache
from mrts.coordination.denser_motion import WHOLE_WAY, polynomial_weights
from mrts.kernel.c_text import cell_source, function_of_lanes
from mrts.kernel.cell_library import CellLibrary, SparseLimits
from mrts.kernel.compiler import FLAGS
from mrts.kernel.motion_rows import path_places, path_rows, widenings
from mrts.kernel.programs import OPTIMAL
from mrts.kernel.sample_terms import SampleTerms
from mrts.kernel.tracking import closure_sizes
from mrts.limits import limit_rows
from mrts.retiming.path_pieces import PLACES

C = ROOT / "mrts" / "kernel" / "c"
GCC = shutil.which("gcc") or "gcc"
CELLS = {"planar_dual_arm": "lift.yaml", "dual_ur5": "lift_and_turn.yaml"}
SAMPLES = 301
"""Two chunks, and a last group that is not full."""

ROUNDING = 1e-12
"""Of c², relative: two orders of the same operations."""

HALF_A_UNIT = 2.0**-53
"""In the last place of 1: what rounding leaves of a sine; entries of rotations are added to others of size 1."""

SOLVED = 1e-10
"""Of the largest widening or number of a motion: a linear program of rows that differ by rounding."""

FINAL = 1e-8
"""Of how far a projection reaches, relative and in limits: an edge is final if nothing lies 1e-9 outside."""

ANGLES = """
#include "lanes/lanes.c"
MRTS_LANE_FUNCTION(mrts_form_of_lanes) { (void)arg, (void)sines, (void)res; }
MRTS_LANE_FUNCTION(mrts_kinematics_of_lanes) { (void)arg, (void)sines, (void)res; }
MRTS_LANE_FUNCTION(mrts_bias_of_lanes) { (void)arg, (void)sines, (void)res; }
#ifdef MRTS_WIDE
MRTS_LANE_FUNCTION(mrts_form_of_wide_lanes) { (void)arg, (void)sines, (void)res; }
MRTS_LANE_FUNCTION(mrts_kinematics_of_wide_lanes) { (void)arg, (void)sines, (void)res; }
MRTS_LANE_FUNCTION(mrts_bias_of_wide_lanes) { (void)arg, (void)sines, (void)res; }
#endif
void angles(long long count, const mrts_lanes *angle, mrts_lanes *sine, mrts_lanes *cosine) {
    for (long long i = 0; i < count; ++i) {
        mrts_lanes both[2];
        mrts_sine_cosine_lanes(angle[i], both);
        sine[i] = both[0];
        cosine[i] = both[1];
    }
}
"""


@pytest.fixture(scope="module", params=["planar_dual_arm", pytest.param("dual_ur5", marks=pytest.mark.slow)])
def ranges(request, tmp_path_factory):
    """The ranges of a shipped cell, with a margin and with more terms, by a library compiled with some flags."""
    path = DATA.parent / request.param
    folder = tmp_path_factory.mktemp(request.param)
    manifest, generated = generated_in_cache(path / "cell.yaml")
    (folder / "cell.c").write_text(cell_source(manifest, generated.read_text(encoding="utf-8")), encoding="utf-8")
    cell = mrts.load_cell(path / "cell.yaml")
    given = yaml.safe_load((path / CELLS[request.param]).read_text()) | {"samples": SAMPLES}
    motion = mrts.follow_object(cell, mrts.sample_motion(mrts.MotionDescription.model_validate(given)))
    rows = limit_rows(cell.without_velocity_limits(), motion)
    matrix = np.hstack([rows.torque_matrix, rows.wrench_matrix])
    limits = SparseLimits(matrix=matrix, lower=rows.lower, upper=rows.upper, group=[name.unit for name in rows.names])
    rng = np.random.default_rng(0)
    size = np.where(np.isfinite(rows.upper), np.abs(rows.upper), 0)
    terms = SampleTerms(
        square=rng.normal(size=(SAMPLES, len(matrix))) * size * 1e-3,
        offset=rng.normal(size=(SAMPLES, len(matrix))) * size * 1e-3,
        margin=rng.random((SAMPLES, len(matrix))) * size * 1e-3,
        torque_square=rng.normal(size=(SAMPLES, motion.q.shape[1])),
        torque_offset=rng.normal(size=(SAMPLES, motion.q.shape[1])),
    )
    inputs = motion.inputs(cell.load) | {GEOMETRY: cell.geometry}

    W = rng.uniform(0.5, 2.0, size=motion.q.shape[1])
    c2 = np.repeat(rng.choice([0.5, 1.0, 2.0, 200.0], size=(SAMPLES + 19) // 20), 20)[:SAMPLES]
    units = np.where(size > 0, size, 1.0)

    @cache
    def found(*flags):
        rng_of_speeds = np.random.default_rng(2)
        library = folder / f"lib{len(list(folder.iterdir()))}.so"
        subprocess.run([GCC, *FLAGS, *flags, folder / "cell.c", "-o", library, "-lm"], check=True)
        opened = CellLibrary(manifest, library)
        most = np.full(SAMPLES, np.inf)
        ranges = [opened.ranges(SAMPLES, inputs, limits, one, most) for one in (SampleTerms(), terms)]
        dense = [widenings(opened, SAMPLES, inputs, limits, units, one, c2)[0] for one in (SampleTerms(), terms)]
        path = (motion.object.time, motion.q, motion.dq, motion.ddq)
        speeds = rng_of_speeds.random(SAMPLES) + 1, rng_of_speeds.random((SAMPLES - 1, 2))
        weights = (PLACES, polynomial_weights(PLACES), WHOLE_WAY)
        places = path_places(opened, path, weights, speeds, cell.geometry, cell.wrench_rows)
        many_weights = [np.eye(opened.joints), np.diag(W) + 0.1 * np.outer(W, W)]
        least = [
            opened.torques(SAMPLES, inputs, limits, one, np.full(SAMPLES, 0.9 * top), weight, 1e-9)
            for weight in many_weights
            for one, top in ((SampleTerms(), np.min(ranges[0].upper)), (terms, np.min(ranges[1].upper)))
        ]
        rows = path_rows(opened, SAMPLES, inputs, limits, units, SampleTerms(), np.zeros(motion.q.shape))
        effect = np.max(np.abs(rows.A), axis=1)
        scale = np.divide(1.0, effect, out=np.zeros_like(effect), where=effect > 0)
        far = np.full((SAMPLES, 2), 1e5) * (scale[:, -2:] > 0)
        projected = opened.programs.projections(
            rows.A, rows.lower, rows.upper, scale, (np.column_stack([-far[:, 0], 0 * far[:, 1]]), far)
        )
        closed = closure_sizes(opened, inputs, motion.object.position + 1e-3, cell.geometry, cell.wrench_rows)
        return ranges, dense, places, least, projected, closed

    return found


def reaches(number, corners):
    """How far each projection reaches in some directions: two may differ by a corner that is none but for rounding."""
    angle = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    directions = np.array([np.cos(angle), np.sin(angle)])
    return [np.max(polygon @ directions, axis=0) for polygon in np.split(corners, np.cumsum(number)[:-1])]


def test_lanes_give_the_same_bits_whatever_the_registers_and_the_answers_of_single_samples(ranges):
    wide, narrow, single = ranges(), ranges("-DMRTS_NARROW", "-O1"), ranges("-DMRTS_NO_LANES", "-O1")
    for part in (1, 2):
        for one, other, alone in zip(wide[part], narrow[part], single[part], strict=True):
            np.testing.assert_array_equal(one, other)
            np.testing.assert_allclose(one, alone, rtol=SOLVED, atol=SOLVED * np.max(np.abs(alone)))
    for one, other, alone in zip(wide[3], narrow[3], single[3], strict=True):
        for of_wide, of_narrow, of_single in zip(one, other, alone, strict=True):
            np.testing.assert_array_equal(of_wide, of_narrow)
            np.testing.assert_allclose(of_wide, of_single, rtol=SOLVED, atol=SOLVED * np.max(of_single))
        assert np.all(one[2] == OPTIMAL)
        assert np.any(one[0] != alone[0]), "the lanes have not been at work"
    for of_wide, of_narrow in zip(wide[4], narrow[4], strict=True):
        np.testing.assert_array_equal(of_wide, of_narrow)
    for one, other in zip(reaches(*wide[4][:2]), reaches(*single[4][:2]), strict=True):
        np.testing.assert_allclose(one, other, rtol=FINAL, atol=FINAL)
    assert np.all(wide[4][2] == OPTIMAL)
    assert not np.array_equal(wide[4][1], single[4][1]), "the lanes have not been at work"
    assert single[5] is None
    np.testing.assert_array_equal(list(vars(wide[5]).values()), list(vars(narrow[5]).values()))
    for shares in wide[1]:
        assert np.any(shares == 0)
        assert np.max(shares) > 1e-2
    for one, other, alone in zip(wide[0], narrow[0], single[0], strict=True):
        for name in ("lower", "upper", "status", "effect", "basis", "dual"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        np.testing.assert_array_equal(one.status, alone.status)
        np.testing.assert_allclose(one.effect, alone.effect, rtol=ROUNDING)
        np.testing.assert_allclose(one.lower, alone.lower, rtol=ROUNDING, atol=ROUNDING)
        np.testing.assert_allclose(one.upper, alone.upper, rtol=ROUNDING)
        assert np.any(one.upper != alone.upper), "the lanes have not been at work"


@pytest.mark.parametrize("ranges", ["planar_dual_arm"], indirect=True)
def test_torques_of_many_arms_are_found_singly(ranges):
    """In lanes their programs would fill the stack."""
    single, many = ranges("-DMRTS_NO_LANES", "-O1")[3], ranges("-DMRTS_MOST_LANE_UNKNOWNS=1", "-O1")[3]
    for one, other in zip(single, many, strict=True):
        for of_one, of_other in zip(one, other, strict=True):
            np.testing.assert_allclose(of_one, of_other, rtol=SOLVED, atol=SOLVED * np.max(of_one))


def test_sines_and_cosines_are_those_of_extended_precision(tmp_path):
    (tmp_path / "angles.c").write_text(ANGLES)
    library = tmp_path / "angles.so"
    subprocess.run([GCC, *FLAGS, f"-I{C}", tmp_path / "angles.c", C / "basis" / "kept_basis.c",
                    C / "linear_programs.c", "-o", library, "-lm"], check=True)  # fmt: skip
    rng = np.random.default_rng(1)
    near = np.arange(-40, 41)[:, None] * (np.pi / 4) + rng.normal(size=500) * 1e-6
    angle = np.concatenate(
        [
            rng.uniform(-7, 7, 200_000),
            rng.uniform(-1e5, 1e5, 100_000),
            near.ravel(),
            [0.0, -0.0, 1e-300, 1e5, -1e5, 1e9],
        ]
    )
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


def test_a_statement_of_another_kind_is_left_to_single_samples():
    text = (
        "static int f0(const casadi_real** arg, casadi_real** res) {\n  casadi_real a0, a1;\n"
        "  a0=arg[0]? arg[0][0] : 0;\n"
        "  a1=%s;\n  if (res[0]!=0) res[0][0]=a1;\n  return 0;\n}\n\n"
        "int form(const casadi_real** arg, casadi_real** res) {\n  return f0(arg, res);\n}\n"
    )
    assert "a1=sines[0];" in function_of_lanes(text % "sin(a0)", "form", "form")
    for other in ("tan(a0)", "(a0+a0);\n  a1=sin(a1)"):
        assert function_of_lanes(text % other, "form", "form") == ""

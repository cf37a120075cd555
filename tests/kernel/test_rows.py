"""rows.c, which the desktop and exported libraries share, against numpy: units, rows, columns, caps."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest
from conftest import ROOT

import mrts
from mrts.kernel.cell_library import SparseLimits
from mrts.kernel.sample_terms import SampleTerms
from mrts.limits.rows import LimitRows

JOINTS, WRENCHES, K = 4, 3, 5
UNITS = ("N m", "N m", "N", "N", "N m")


FORM = ("torque_map", "torque_offset", "wrench_map", "wrench_offset", "object_map", "object_offset")


class Form(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in FORM]


class Rows(ctypes.Structure):
    _fields_ = [
        ("count", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in ("which", "unit", "A", "lower", "upper", "size")),
    ]


@pytest.fixture(scope="module")
def rows_c(tmp_path_factory):
    library = tmp_path_factory.mktemp("rows") / "rows.so"
    source = ROOT / "mrts" / "kernel" / "c" / "rows.c"
    compiler = shutil.which("gcc") or shutil.which("cc")
    subprocess.run([compiler, "-std=c99", "-fPIC", "-shared", source, "-o", library, "-lm"], check=True)
    loaded = ctypes.CDLL(str(library))
    loaded.mrts_speed_cap.restype = ctypes.c_double
    return loaded


def address(array):
    return ctypes.c_void_p(array.ctypes.data)


def some_limits(rng):
    """A zero limit beside others of its unit, one without, one-sided ones, and a row without a limit."""
    lower = np.array([-5.0, 0.0, 0.0, -np.inf, -np.inf])
    upper = np.array([3.0, 0.0, 0.0, np.inf, 7.0])
    names = tuple(mrts.RowName("torque", "arm", str(place), unit) for place, unit in enumerate(UNITS))
    matrix = rng.normal(size=(len(UNITS), JOINTS + WRENCHES)) * (rng.random((len(UNITS), JOINTS + WRENCHES)) < 0.6)
    return LimitRows(
        names=names, torque_matrix=matrix[:, :JOINTS], wrench_matrix=matrix[:, JOINTS:], lower=lower, upper=upper
    )


def built(loaded, limits, form, square):
    """Rows as C builds them, with the arrays that they stand in."""
    matrix = np.hstack([limits.torque_matrix, limits.wrench_matrix])
    sparse = SparseLimits(matrix=matrix, lower=limits.lower, upper=limits.upper, group=UNITS)
    r = len(UNITS)
    work, which, rows = np.zeros(r * K + 3 * r + 3 * K), np.zeros(r, dtype=np.int32), Rows()
    loaded.mrts_rows_over(K, ctypes.byref(sparse.structure), address(work), address(which), ctypes.byref(rows))
    maps = Form(*(address(part) for part in form))
    given = ctypes.byref(SampleTerms(square=square).structure())
    finite = loaded.mrts_build_rows(
        K, JOINTS, WRENCHES, ctypes.byref(maps), ctypes.byref(sparse.structure), given, ctypes.byref(rows)
    )
    return finite, rows, which[: rows.count], work, sparse


def some_form(rng):
    shapes = ((K, JOINTS), (JOINTS,), (K, WRENCHES), (WRENCHES,))
    return [np.ascontiguousarray(rng.normal(size=shape)) for shape in shapes]


@pytest.mark.parametrize("with_square", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_rows_equal_those_of_numpy(seed, with_square, rows_c):
    rng = np.random.default_rng(seed)
    limits, form = some_limits(rng), some_form(rng)
    square = rng.normal(size=len(UNITS)) if with_square else None
    finite, rows, which, work, _ = built(rows_c, limits, form, square)
    assert finite
    assert which.tolist() == [0, 1, 2, 4]
    unit = limits.bounded().units()
    assert unit.tolist() == [5.0, 7.0, 1.0, 7.0]
    torque_map, torque_offset, wrench_map, wrench_offset = form
    A = limits.torque_matrix @ torque_map.T + limits.wrench_matrix @ wrench_map.T
    A[:, -1] += 0 if square is None else square
    offset = limits.torque_matrix @ torque_offset + limits.wrench_matrix @ wrench_offset
    r, count = len(UNITS), rows.count
    np.testing.assert_array_equal(work[:count], unit)
    np.testing.assert_allclose(work[r : r + count * K].reshape(count, K), A[which] / unit[:, None], atol=1e-14)
    for side, start in ((limits.lower, r + r * K), (limits.upper, r + r * K + r + K)):
        wanted = np.clip((side - offset)[which] / unit, -1e300, 1e300)
        np.testing.assert_allclose(work[start : start + count], wanted, rtol=1e-13, atol=1e-14)


def test_a_coefficient_that_is_not_finite_is_noticed(rows_c):
    rng = np.random.default_rng(0)
    form = some_form(rng)
    form[0][0, 0] = np.inf
    assert not built(rows_c, some_limits(rng), form, None)[0]


def test_reversed_limits_are_refused():
    with pytest.raises(ValueError, match=r"rows \[1\]"):
        SparseLimits(matrix=np.eye(2), lower=np.array([0.0, 1.0]), upper=np.array([1.0, 0.0]), group=("N", "N"))


def test_wrenches_are_turned_into_object_axes(rows_c):
    """Spatial and planar arms, with the object's rotation given row after row and column after column."""
    rng = np.random.default_rng(6)
    for arms, size, axes in ((2, 6, (0, 1, 2)), (1, 3, (0, 2, 1)), (3, 3, (1, 2, 0))):
        wrenches = arms * size
        R, base = (np.linalg.qr(rng.normal(size=shape))[0] for shape in ((3, 3), (arms, 3, 3)))
        wrench_map, wrench_offset = rng.normal(size=(K, wrenches)), rng.normal(size=wrenches)
        limits = SparseLimits(matrix=np.eye(1), lower=np.zeros(1), upper=np.ones(1), group=("N",), base=base, axes=axes)
        turn = R.T[list(axes)] @ base
        wanted = np.einsum("aij,katj->kati", turn, np.vstack([wrench_map, wrench_offset]).reshape(K + 1, arms, -1, 3))
        for rotation, down, across in ((R, 3, 1), (R.T, 1, 3)):
            memory = np.zeros((K + 1, wrenches))
            form = Form(None, None, address(wrench_map), address(wrench_offset), None, None)
            given = np.ascontiguousarray(rotation)
            rows_c.mrts_turn_wrenches(
                K, arms, size, ctypes.byref(limits.structure), address(given), down, across, address(memory),
                ctypes.byref(form),
            )  # fmt: skip
            assert form.object_map == memory.ctypes.data
            np.testing.assert_allclose(memory, wanted.reshape(K + 1, wrenches), atol=1e-14)


def test_velocities_cap_the_speed(rows_c):
    dq, twist = np.array([0.5, -2.0, 1.0]), np.array([0.0, 3.0, 4.0, 0.0, 0.0, 1.0])
    binding = ctypes.c_int()

    def cap(*limit):
        given = np.array([1e300 if value is None else value for value in limit])
        found = rows_c.mrts_speed_cap(3, address(dq), address(twist), address(given), ctypes.byref(binding))
        return found, binding.value

    assert cap(1.0, 2.0, 4.0, None, None) == (1.0, 1)
    assert cap(None, None, None, 2.5, None) == (0.25, 3)
    assert cap(None, None, None, None, 0.5) == (0.25, 4)
    assert cap(None, None, None, None, None) == (1e300, -1)

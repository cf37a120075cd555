"""Generated functions as C of doubles, floats and lanes: the numbers of CasADi's virtual machine."""

import ctypes
from functools import cache

import casadi as ca
import numpy as np
import pytest
from conftest import DATA, ROOT
from exported_library import run, tool
from mrts_codegen.embedded.export_library import TEMPLATES, filled
from mrts_codegen.generate import generate_cell
from mrts_codegen.model_c import ANGLES, OPERATIONS, model_c
from shipped_cells import sizes_of

import mrts

C = ROOT / "mrts" / "kernel" / "c"
ROUNDING = {"double": 1e-13, "float": 1e-4}
"""Of some thousand operations, relative to the largest entry."""

TYPES = {"double": (ctypes.c_double, np.float64), "float": (ctypes.c_float, np.float32)}


@cache
def functions_of(cell):
    return generate_cell(DATA.parent / cell / "cell.yaml")[2]


def compiled(functions, precision, folder):
    """The functions as a shared library, as an export has them; in lanes as well where they are doubles."""
    words = {"NOTICE": "", "MODEL": model_c({f"x_{short}": one for short, one in functions.items()})}
    template = (TEMPLATES / "cell_model.c").read_text()
    text = filled(template.replace("cell_", "x_").replace("kernel/", ""), words)
    joints = min(one.numel_in(0) for one in functions.values())  # all take them first
    kind = {"float": "#define MRTS_SINGLE\n"}.get(precision, "")
    sizes = f'#define CELL_JOINTS {joints}\n#define MRTS_REAL {precision}\n{kind}#include "numbers.h"\n'
    (folder / "x_model.h").write_text(f"typedef {precision} x_real;\n{sizes}")
    if precision == "double":
        text += f'#include "lanes/lanes.h"\n#include "lanes/model_of_lanes.inc"\n{words["MODEL"]}'
    (folder / "model.c").write_text(text)
    run(tool("gcc", "gcc"), "-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion",
        "-Wdouble-promotion", "-Werror", "-Wno-missing-prototypes", f"-I{C}", *sizes_of("planar_dual_arm"),
        "-shared", "-fPIC", folder / "model.c",
        "-lm", "-o", folder / "model.so")  # fmt: skip
    return ctypes.CDLL(str(folder / "model.so"))


def pointers(arrays, kind):
    return (ctypes.POINTER(kind) * len(arrays))(*(array.ctypes.data_as(ctypes.POINTER(kind)) for array in arrays))


def called(library, short, function, given, precision):
    """Outputs of one function, by columns."""
    kind, dtype = TYPES[precision]
    arrays = [np.asfortranarray(value, dtype=dtype).ravel(order="F") for value in given]
    found = [np.zeros(function.numel_out(i), dtype=dtype) for i in range(function.n_out())]
    getattr(library, f"x_{short}")(pointers(arrays, kind), pointers(found, kind))
    return found


def called_in_lanes(library, short, function, samples):
    """Outputs of one function of four samples side by side, by columns."""
    arrays = [np.stack([value.ravel(order="F") for value in given], axis=-1) for given in zip(*samples, strict=True)]
    sines = np.stack([np.sin(arrays[0]), np.cos(arrays[0])], axis=1)
    found = [np.zeros((function.numel_out(i), 4)) for i in range(function.n_out())]
    kind = ctypes.c_double
    getattr(library, f"x_{short}_lanes")(pointers(arrays, kind), *pointers([sines], kind), pointers(found, kind))
    return [[values[:, lane] for values in found] for lane in range(4)]


def agree(library, functions, precision, rng):
    for short, function in functions.items():
        samples = [[rng.uniform(-1, 1, function.size_in(i)) for i in range(function.n_in())] for _ in range(4)]
        answers = [[called(library, short, function, given, precision) for given in samples]]
        if precision == "double":
            answers.append(called_in_lanes(library, short, function, samples))
        for found in answers:
            for ours, given in zip(found, samples, strict=True):
                wanted = [np.asarray(value).ravel(order="F") for value in function.call(given)]
                for one, other in zip(ours, wanted, strict=True):
                    assert np.max(np.abs(one - other)) <= ROUNDING[precision] * (1 + np.max(np.abs(other))), short


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("cell", ["planar_dual_arm", "dual_ur5"])
def test_the_functions_of_a_cell_are_those_of_the_virtual_machine(cell, precision, tmp_path):
    functions = functions_of(cell)
    agree(compiled(functions, precision, tmp_path), functions, precision, np.random.default_rng(0))


@pytest.mark.parametrize("precision", ["double", "float"])
def test_every_operation_is_that_of_the_virtual_machine(precision, tmp_path):
    x = ca.SX.sym("x", 3)
    y = x + 2.5
    parts = [y[0] + y[1], y[0] - y[2], y[0] * y[1], y[0] / y[1], -y[0], 1 / y[1], y[2] ** 2, 2 * y[0], x[1], 3, 1e-300]
    parts += [ca.sin(x[0]), ca.cos(x[1]), ca.sin(y[0]), ca.cos(y[1]), ca.sqrt(y[2]), ca.fabs(x[2])]
    function = ca.Function("each", [x], [ca.densify(ca.vertcat(*parts))])
    used = {function.instruction_id(k) for k in range(function.n_instructions())}
    assert OPERATIONS.keys() | ANGLES.keys() <= used | {ca.OP_ASSIGN}  # an assignment is optimised away
    agree(compiled({"each": function}, precision, tmp_path), {"each": function}, precision, np.random.default_rng(2))


def test_what_it_does_not_know_is_refused():
    x = ca.SX.sym("x", 2)
    with pytest.raises(mrts.InputError, match="of which no C is known"):
        model_c({"angle": ca.Function("angle", [x], [ca.atan2(x[0], x[1])])})
    with pytest.raises(mrts.InputError, match="holds a number that is not finite"):
        model_c({"endless": ca.Function("endless", [x], [x[0] + ca.inf])})

# SPDX-License-Identifier: MIT
"""Generated functions as straight-line C for any type of number: a double, a float, or several side by side."""

from textwrap import wrap

import casadi as ca

from mrts.base.errors import InputError
from mrts.base.manifest import FunctionRecord

OPERATIONS: dict[int, str] = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_NEG: "-{0}",
    ca.OP_INV: "1 / {0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "{0} + {0}",
    ca.OP_SQRT: "MRTS_MATH(sqrt, {0})",
    ca.OP_FABS: "MRTS_MATH(fabs, {0})",
}
"""C of CasADi's operations on scalars."""

ANGLES: dict[int, tuple[str, str]] = {ca.OP_SIN: ("MRTS_SIN", "sin"), ca.OP_COS: ("MRTS_COS", "cos")}
"""Those of an angle: the macro for a joint's, entry j of the first input, and the function of math.h for others."""

DOUBLE = """#include <math.h>

/* What a number is. A text that takes functions from here for another type gives its own of these. */
#define MRTS_MODEL(name, signature) \\
    const char name##_signature[] = signature; \\
    void name(const double *const *arg, double *const *res)
#define MRTS_NUMBER double
#define MRTS_CONSTANT(value) value
#define MRTS_MATH(function, a) function(a)
#define MRTS_SIN(joint, a) sin(a)
#define MRTS_COS(joint, a) cos(a)
"""
"""What the functions of `model_c` want to be of doubles."""

LINE = 110
"""Width of the lists of variables."""


def model_c(functions: dict[str, ca.Function]) -> str:
    """C definitions of functions of `arg` and `res`, the same bytes for the same expressions.

    CasADi's virtual machine runs these instructions in this order, so both agree to rounding.
    """
    return "\n".join(
        f'MRTS_MODEL({name}, "{function_record(name, function).signature}") {{\n{_body(function.expand())}}}\n'
        for name, function in functions.items()
    )


def function_record(name: str, function: ca.Function) -> FunctionRecord:
    """What the manifest tells of a function of that name."""
    return FunctionRecord(
        symbol=name,
        instructions=function.n_instructions(),
        inputs={function.name_in(i): function.size_in(i) for i in range(function.n_in())},
        outputs={function.name_out(i): function.size_out(i) for i in range(function.n_out())},
    )


def _body(function: ca.Function) -> str:
    joints: dict[int, int] = {}  # variables that hold an entry of the first input
    lines = []
    for k in range(function.n_instructions()):
        code, given, found = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_OUTPUT:
            lines.append(f"    res[{found[0]}][{found[1]}] = a{given[0]};\n")
            continue
        if code == ca.OP_CONST:
            value = float(function.instruction_constant(k))
            if not abs(value) < ca.inf:
                raise InputError(function.name(), "holds a number that is not finite.", value=value)
            right = f"MRTS_CONSTANT({value!r})"
        elif code == ca.OP_INPUT:
            right = f"arg[{given[0]}][{given[1]}]"
        elif code in ANGLES:
            of_joint, other = ANGLES[code]
            joint = joints.get(given[0])
            right = f"MRTS_MATH({other}, a{given[0]})" if joint is None else f"{of_joint}({joint}, a{given[0]})"
        elif code in OPERATIONS:
            right = OPERATIONS[code].format(*(f"a{place}" for place in given))
        else:
            raise InputError(
                function.name(),
                f"uses CasADi's operation {code}, of which no C is known. Add it to OPERATIONS of codegen/model_c.py.",
            )
        joints.pop(found[0], None)
        if code == ca.OP_INPUT and given[0] == 0:
            joints[found[0]] = given[1]
        lines.append(f"    a{found[0]} = {right};\n")
    variables = wrap(", ".join(f"a{place}" for place in range(function.sz_w())), LINE)
    declared = "".join(f"    MRTS_NUMBER {line.rstrip(',')};\n" for line in variables)
    return declared + "".join(lines)

# SPDX-License-Identifier: MIT
"""The generated functions of a cell as straight-line C in the library's real type."""

from collections.abc import Callable, Iterable
from textwrap import wrap

import casadi as ca
from mrts_codegen.embedded.c_literals import Precision, c_number

from mrts.base.errors import InputError

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
}
"""C of CasADi's operations on scalars."""

FUNCTIONS: dict[int, str] = {ca.OP_SIN: "sin", ca.OP_COS: "cos", ca.OP_SQRT: "sqrt"}
"""Its functions that stand in math.h, there with an f behind the name for float. Rigid bodies need no more."""

LINE = 110
"""Width of the lists of variables."""


def function_body(function: ca.Function, real: str, precision: Precision) -> str:
    """Statements of a function of `arg` and `res`, the same for the same expression.

    CasADi's virtual machine runs these instructions in this order, so both agree to rounding.

    Args:
        function: Any that expands into scalars.
        real: C type of its variables.
        precision: Of that type.

    Raises:
        InputError: If it holds an operation or a number that C does not know.
    """
    scalar = function.expand()
    suffix = "f" if precision == "float" else ""
    operations = OPERATIONS | {code: f"{name}{suffix}({{0}})" for code, name in FUNCTIONS.items()}
    lines = []
    for k in range(scalar.n_instructions()):
        code, given, found = scalar.instruction_id(k), scalar.instruction_input(k), scalar.instruction_output(k)
        if code == ca.OP_CONST:
            right = _constant(function.name(), scalar.instruction_constant(k), precision)
        elif code == ca.OP_INPUT:
            right = f"arg[{given[0]}][{given[1]}]"
        elif code == ca.OP_OUTPUT:
            right = f"a{given[0]}"
        elif code in operations:
            right = operations[code].format(*(f"a{place}" for place in given))
        else:
            raise InputError(
                function.name(),
                f"uses CasADi's operation {code}, which an exported library does not know. Add its C to OPERATIONS of "
                "codegen/embedded/model_source.py.",
            )
        left = f"res[{found[0]}][{found[1]}]" if code == ca.OP_OUTPUT else f"a{found[0]}"
        lines.append(f"    {left} = {right};\n")
    variables = wrap(", ".join(f"a{place}" for place in range(scalar.sz_w())), LINE)
    declared = "".join(f"    {real} {line.rstrip(',')};\n" for line in variables)
    return declared + "".join(lines)


def model_source(functions: dict[str, ca.Function], name: str, precision: Precision) -> str:
    """Definitions of the functions, each under a line that tells its arguments.

    Args:
        functions: By short name.
        name: Of the library.
        precision: "double" or "float".

    Raises:
        InputError: As `function_body`.
    """
    return "\n".join(
        f"/* {short}: {_signature(function)} */\n{_prototype(name, short)} {{\n"
        f"{function_body(function, f'{name}_real', precision)}}}\n"
        for short, function in functions.items()
    )


def model_prototypes(functions: Iterable[str], name: str) -> str:
    """Declarations of the functions of `model_source`, by short name."""
    return "".join(f"{_prototype(name, short)};\n" for short in functions)


def _prototype(name: str, short: str) -> str:
    return f"void {name}_model_{short}(const {name}_real *const *arg, {name}_real *const *res)"


def _constant(function: str, value: float, precision: Precision) -> str:
    if not abs(value) < ca.inf:
        raise InputError(function, "holds a number that is not finite.", value=value)
    return c_number(value, precision)


def _signature(function: ca.Function) -> str:
    def items(count: int, named: Callable[[int], str], sized: Callable[[int], tuple[int, int]]) -> str:
        return ", ".join(f"{named(i)}[{sized(i)[0]}x{sized(i)[1]}]" for i in range(count))

    given = items(function.n_in(), function.name_in, function.size_in)
    return f"{given} -> {items(function.n_out(), function.name_out, function.size_out)}"

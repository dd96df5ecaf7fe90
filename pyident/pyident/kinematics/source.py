"""Expressions -> C: one line per operation, each on a vector of samples (`lanes.h`)."""

from collections.abc import Iterator
from importlib.resources import files

import casadi as ca

_OPERATIONS = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_NEG: "-{0}",
    ca.OP_INV: "1.0 / {0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "{0} + {0}",
    ca.OP_SQRT: "sqrt_of({0})",
    ca.OP_SIN: "sin_of({0})",
    ca.OP_COS: "cos_of({0})",
}


def source(function: ca.Function) -> str:
    """C of a function (q, dq, ddq) -> Phi, with `fill` of lanes.h around it."""
    fixed = files("pyident.kinematics").joinpath("lanes.h").read_text(encoding="utf-8")
    return "\n".join(
        [
            f"#define N_Q {function.numel_in(0)}",
            f"#define N_PHI {function.numel_out(0)}",
            fixed,
            "static void point(const lanes *q, const lanes *dq, const lanes *ddq, lanes *Phi)",
            "{",
            *_lines(function),
            "}",
            "",
        ]
    )


def _lines(function: ca.Function) -> Iterator[str]:
    """CasADi reuses the places of its work vector; in C every value gets a name of its own."""
    names: dict[int, str] = {}
    for k in range(function.n_instructions()):
        operation, inputs = function.instruction_id(k), function.instruction_input(k)
        if operation == ca.OP_OUTPUT:
            yield f"    Phi[{function.instruction_output(k)[1]}] = {names[inputs[0]]};"
            continue
        if operation == ca.OP_INPUT:
            value = f"{('q', 'dq', 'ddq')[inputs[0]]}[{inputs[1]}]"
        elif operation == ca.OP_CONST:
            value = f"each({function.instruction_constant(k)!r})"
        elif operation in _OPERATIONS:
            value = _OPERATIONS[operation].format(*(names[i] for i in inputs))
        else:
            raise NotImplementedError(f"operation {operation} of CasADi has no C yet; add it to _OPERATIONS")
        name = names[function.instruction_output(k)[0]] = f"a{k}"
        yield f"    const lanes {name} = {value};"

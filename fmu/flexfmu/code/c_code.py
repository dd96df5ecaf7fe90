"""casadi.Function of scalars -> C over `real`, which runtime/plant/scalar.h and runtime/batch/lanes.h define.

The same text is compiled for one number and for a vector of runs. Long functions are cut into pieces: a
compiler's time grows faster than the length of a function.
"""

from collections.abc import Iterator
from typing import Any

import casadi as ca

_PIECE = 250  # instructions of one piece
_INFIX = {ca.OP_ADD: "+", ca.OP_SUB: "-", ca.OP_MUL: "*", ca.OP_DIV: "/"}
_UNARY = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "{0} + {0}",
    ca.OP_INV: "REAL(1.0) / {0}",
}
_CALLS = {
    getattr(ca, f"OP_{name}"): f"R_{name}"
    for name in (
        *("EXP", "LOG", "POW", "CONSTPOW", "SQRT", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "SINH"),
        *(
            "COSH",
            "TANH",
            "ATAN2",
            "FABS",
            "SIGN",
            "FMIN",
            "FMAX",
            "LT",
            "LE",
            "EQ",
            "NE",
            "NOT",
            "AND",
            "OR",
        ),
        *("IF_ELSE_ZERO", "FLOOR", "CEIL", "FMOD", "COPYSIGN", "EXPM1", "LOG1P", "HYPOT", "ERF"),
    )
}


def c_function(function: ca.Function, name: str, inputs: tuple[str, ...], outputs: tuple[str, ...]) -> str:
    """C of `name`(inputs..., outputs...): arrays of `real`; an output may be NULL.

    Vectors are dense; what is structurally zero is written as 0.
    """
    expanded = _dense(function)
    pieces = list(_pieces(expanded, inputs, outputs))
    takes = ", ".join([*(f"const real *{n}" for n in inputs), *(f"real *{n}" for n in outputs)])
    hands = ", ".join([*inputs, *outputs])
    out = []
    for i, lines in enumerate(pieces):
        body = "\n".join(f"    {line}" for line in lines)
        unused = "".join(f"(void){n}; " for n in (*inputs, *outputs))
        out.append(f"static void PIECE({name}_{i})({takes}, real *w) {{\n    {unused}(void)w;\n{body}\n}}\n")
    calls = "\n".join(f"    PIECE({name}_{i})({hands}, w);" for i in range(len(pieces)))
    size = max(1, expanded.sz_w())
    return "\n".join(out) + f"\nvoid NAME({name})({takes}) {{\n    real w[{size}];\n{calls}\n}}\n"


def prototype(name: str, inputs: tuple[str, ...], outputs: tuple[str, ...]) -> str:
    """The declaration in C of a generated function, each input and output a dense array."""
    takes = ", ".join([*(f"const real *{n}" for n in inputs), *(f"real *{n}" for n in outputs)])
    return f"void NAME({name})({takes});"


def _dense(function: ca.Function) -> ca.Function:
    """What outputs share is found in all of them at once: one by one they would no longer share it."""
    symbols = function.sx_in()
    shared = ca.cse(function.call(symbols))
    return ca.Function(function.name(), symbols, [ca.densify(y) for y in shared])


def _pieces(f: ca.Function, inputs: tuple[str, ...], outputs: tuple[str, ...]) -> Iterator[list[str]]:
    """Statements of every piece. What a later piece reads goes through w; all else is local."""
    steps = [
        (f.instruction_id(i), f.instruction_input(i), f.instruction_output(i), i)
        for i in range(f.n_instructions())
    ]
    later = _read_later([steps[a : a + _PIECE] for a in range(0, len(steps), _PIECE)])
    for first, wanted in zip(range(0, max(1, len(steps)), _PIECE), later, strict=True):
        yield _piece(f, steps[first : first + _PIECE], wanted, inputs, outputs)


def _piece(f: ca.Function, steps: list, wanted: set[int], inputs: Any, outputs: Any) -> list[str]:
    known: set[int] = set()
    written: set[int] = set()
    loads, body = [], []
    for op, read, write, i in steps:
        if op == ca.OP_INPUT:
            text = f"{inputs[read[0]]}[{read[1]}]"
        elif op == ca.OP_CONST:
            text = f"REAL({_number(f.instruction_constant(i))})"
        else:
            loads += [f"real a{s} = w[{s}];" for s in dict.fromkeys(read) if s not in known]
            known |= set(read)
            names = [f"a{s}" for s in read]
            if op == ca.OP_OUTPUT:
                body.append(f"if ({outputs[write[0]]}) {outputs[write[0]]}[{write[1]}] = {names[0]};")
                continue
            text = _expression(op, names)
        slot = write[0]
        body.append(f"{'' if slot in known else 'real '}a{slot} = {text};")
        known.add(slot)
        written.add(slot)
    return [*loads, *body, *(f"w[{s}] = a{s};" for s in sorted(written & wanted))]


def _expression(op: int, names: list[str]) -> str:
    if op in _INFIX:
        return f"{names[0]} {_INFIX[op]} {names[1]}"
    if op in _UNARY:
        return _UNARY[op].format(*names)
    if op in _CALLS:
        return f"{_CALLS[op]}({', '.join(names)})"
    raise NotImplementedError(f"the C generator does not know CasADi's operation {op}")


def _read_later(pieces: list[list]) -> list[set[int]]:
    """Per piece the slots that are read after it before they are written again."""
    live: set[int] = set()
    out: list[set[int]] = []
    for steps in reversed(pieces):
        out.insert(0, set(live))
        for op, read, write, _ in reversed(steps):
            if op != ca.OP_OUTPUT:
                live -= {write[0]}
            if op not in (ca.OP_INPUT, ca.OP_CONST):
                live |= set(read)
    return out or [set()]


def _number(value: float) -> str:
    return repr(float(value)) if value == value and abs(value) != float("inf") else _special(value)


def _special(value: float) -> str:
    return "NAN" if value != value else "HUGE_VAL" if value > 0 else "-HUGE_VAL"

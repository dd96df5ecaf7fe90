"""The model's own C: what differs from robot to robot. Everything else lies in runtime/."""

import hashlib
import os
import tempfile
from importlib import resources
from itertools import pairwise
from pathlib import Path

import casadi as ca

from flexfmu.variables import STEP, identifier, nominals, variables
from flexmodels.plant import Equations

_FUNCTIONS = ("rates", "breakaway", "laws", "balance", "start", "tip")
RUNTIME = Path(str(resources.files("flexfmu") / "runtime"))


def model_sources(equations: Equations, derivatives: bool) -> dict[str, str]:
    """File name -> text of the generated files: model.h, model.c and, on demand, model_derivatives.c."""
    functions = [_renamed(getattr(equations, name)) for name in _FUNCTIONS]
    extra = _derivatives(equations) if derivatives else []
    files = {"model.c": _tables(equations) + _generated(functions, "model")}
    if derivatives:
        files["model_derivatives.c"] = '#include "model.h"\n' + _generated(extra, "derivatives")
    token = hashlib.sha256("".join([*files.values(), repr(variables(equations))]).encode()).hexdigest()[:32]
    return {"model.h": _header(equations, [*functions, *extra], token, derivatives)} | files


def token_of(sources: dict[str, str]) -> str:
    """The instantiation token that the sources carry."""
    line = next(line for line in sources["model.h"].splitlines() if "MODEL_TOKEN" in line)
    return line.split('"')[1]


def _derivatives(equations: Equations) -> list[ca.Function]:
    """Jacobian products of rates (with friction) and tip, forward and reverse."""
    x, u, p, mode = equations.rates.sx_in()
    dx, _, friction = equations.rates.call([x, u, p, mode])
    seeds = [ca.SX.sym("seed", v.numel()) for v in (x, u, p)]
    outputs, inputs = ca.vertcat(dx, friction), ca.vertcat(x, u, p)
    weight = ca.SX.sym("weight", outputs.numel())
    pulled = ca.jtimes(outputs, inputs, weight, True)
    cuts = [0, x.numel(), x.numel() + u.numel(), inputs.numel()]
    split = [pulled[a:b] for a, b in pairwise(cuts)]
    position, lever = equations.tip.call([x])[0], ca.SX.sym("lever", 3)
    return [
        ca.Function(
            "model_rates_forward",
            [x, u, p, mode, *seeds],
            [ca.cse(ca.jtimes(outputs, inputs, ca.vertcat(*seeds)))],
        ),
        ca.Function("model_rates_adjoint", [x, u, p, mode, weight], ca.cse(split)),
        ca.Function("model_tip_forward", [x, seeds[0]], [ca.cse(ca.jtimes(position, x, seeds[0]))]),
        ca.Function("model_tip_adjoint", [x, lever], [ca.cse(ca.jtimes(position, x, lever, True))]),
    ]


def _generated(functions: list[ca.Function], prefix: str) -> str:
    """CasADi's C of the functions; its own helpers carry the prefix."""
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        generator = ca.CodeGenerator(f"{prefix}.c", {"casadi_int": "int", "with_export": False, "cpp": False})
        for function in functions:
            generator.add(function)
        try:
            os.chdir(folder)  # CasADi writes only to the current directory
            generator.generate()
        finally:
            os.chdir(here)
        return (Path(folder) / f"{prefix}.c").read_text()


def _renamed(function: ca.Function) -> ca.Function:
    symbols = function.sx_in()
    return ca.Function(f"model_{function.name()}", symbols, function.call(symbols))


def _header(equations: Equations, functions: list[ca.Function], token: str, derivatives: bool) -> str:
    prototypes = "\n".join(
        f"int {f.name()}(const double **arg, double **res, int *iw, double *w, int mem);" for f in functions
    )
    joints = equations.joints
    return f"""/* Sizes, tables and functions of robot {equations.name}. */
#ifndef MODEL_H
#define MODEL_H

#define MODEL_IDENTIFIER "{identifier(equations)}"
#define MODEL_TOKEN "{token}"
#define N_JOINTS {joints}
#define N_COORDINATES {len(equations.coordinates)}
#define N_MEMORIES {len(equations.memories)}
#define N_STATES (2 * N_COORDINATES + N_MEMORIES)
#define N_PARAMETERS {len(equations.parameters)}
#define PERIOD {equations.controller.period!r}
#define MODEL_STEP {STEP!r}
{"#define MODEL_DERIVATIVES" if derivatives else "/* without derivatives */"}
#define MODEL_SZ_ARG {max(f.sz_arg() for f in functions)}
#define MODEL_SZ_RES {max(f.sz_res() for f in functions)}
#define MODEL_SZ_W {max(1, *(f.sz_w() for f in functions))}

extern const double model_parameters[N_PARAMETERS];
extern const char *const model_parameter_names[N_PARAMETERS];
extern const unsigned char model_nonnegative[N_PARAMETERS];
extern const double model_gains[3 * N_JOINTS]; /* Kp, Kd, Ki */
extern const double model_nominals[N_STATES];
extern const unsigned char model_sticking[N_JOINTS];
extern const int model_stiffness[N_COORDINATES - N_JOINTS + 1]; /* parameter of each deformation */

{prototypes}

#endif
"""


def _tables(equations: Equations) -> str:
    names = list(equations.parameters)
    c = equations.controller
    stiffness = [names.index(q.replace("eps", "k")) for q in equations.coordinates[equations.joints :]]
    return "\n".join(
        [
            '#include "model.h"',
            _array("double", "model_parameters", [repr(float(v)) for v in equations.parameters.values()]),
            _array("char *const", "model_parameter_names", [f'"{n}"' for n in names]),
            _array(
                "unsigned char", "model_nonnegative", [str(int(n in equations.nonnegative)) for n in names]
            ),
            _array("double", "model_gains", [repr(float(v)) for v in (*c.Kp, *c.Kd, *c.Ki)]),
            _array("double", "model_nominals", [repr(v) for v in nominals(equations)]),
            _array("unsigned char", "model_sticking", [str(int(s)) for s in equations.sticking]),
            _array("int", "model_stiffness", [*map(str, stiffness), "0"]),
            "",
        ]
    )


def _array(kind: str, name: str, values: list[str]) -> str:
    return f"const {kind} {name}[] = {{{', '.join(values)}}};"

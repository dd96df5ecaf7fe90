"""The model's own C: what differs from robot to robot. Everything else lies in runtime/."""

import hashlib
import os
import tempfile
from importlib import resources
from pathlib import Path

import casadi as ca

from flexfmu.description import STEP, identifier, variables
from flexmodels.plant import Equations

RUNTIME = Path(str(resources.files("flexfmu") / "runtime"))
_FUNCTIONS = ("rates", "breakaway", "balance", "tip")


def model_sources(equations: Equations) -> dict[str, str]:
    """File name -> text of the generated files: model.h and model.c."""
    functions = [getattr(equations, name) for name in _FUNCTIONS]
    body = _generated(functions)
    token = hashlib.sha256((body + repr(variables(equations))).encode()).hexdigest()[:32]
    return {"model.h": _header(equations, functions, token), "model.c": _tables(equations) + body}


def token_of(sources: dict[str, str]) -> str:
    """The instantiation token that the sources carry."""
    line = next(line for line in sources["model.h"].splitlines() if "MODEL_TOKEN" in line)
    return line.split('"')[1]


def _generated(functions: list[ca.Function]) -> str:
    """CasADi's C of the functions, each renamed model_<name>."""
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        generator = ca.CodeGenerator("body.c", {"casadi_int": "int", "with_export": False, "cpp": False})
        for function in functions:
            generator.add(_renamed(function))
        try:
            os.chdir(folder)  # CasADi writes only to the current directory
            generator.generate()
        finally:
            os.chdir(here)
        return (Path(folder) / "body.c").read_text()


def _renamed(function: ca.Function) -> ca.Function:
    symbols = function.sx_in()
    return ca.Function(f"model_{function.name()}", symbols, function.call(symbols))


def _header(equations: Equations, functions: list[ca.Function], token: str) -> str:
    renamed = [_renamed(f) for f in functions]
    prototypes = "\n".join(
        f"int model_{f.name()}(const double **arg, double **res, int *iw, double *w, int mem);"
        for f in functions
    )
    joints = equations.joints
    return f"""/* Sizes, tables and functions of robot {equations.name}. */
#ifndef MODEL_H
#define MODEL_H

#define MODEL_IDENTIFIER "{identifier(equations)}"
#define MODEL_TOKEN "{token}"
#define N_JOINTS {joints}
#define N_COORDINATES {len(equations.coordinates)}
#define N_PARAMETERS {len(equations.parameters)}
#define PERIOD {equations.controller.period!r}
#define MODEL_STEP {STEP!r}
#define MODEL_SZ_ARG {max(f.sz_arg() for f in renamed)}
#define MODEL_SZ_RES {max(f.sz_res() for f in renamed)}
#define MODEL_SZ_W {max(1, *(f.sz_w() for f in renamed))}

extern const double model_parameters[N_PARAMETERS];
extern const char *const model_parameter_names[N_PARAMETERS];
extern const unsigned char model_nonnegative[N_PARAMETERS];
extern const double model_gains[3 * N_JOINTS]; /* Kp, Kd, Ki */
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
            _array("unsigned char", "model_sticking", [str(int(s)) for s in equations.sticking]),
            _array("int", "model_stiffness", [*map(str, stiffness), "0"]),
            "",
        ]
    )


def _array(kind: str, name: str, values: list[str]) -> str:
    return f"const {kind} {name}[] = {{{', '.join(values)}}};"

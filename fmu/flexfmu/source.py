"""The model's own C: what differs from robot to robot. Everything else lies in runtime/."""

import hashlib
import os
from importlib import resources
from itertools import pairwise
from pathlib import Path

import casadi as ca

from flexfmu.interface import Interface, plant_interface
from flexfmu.names import c_string
from flexfmu.variables import nominals
from flexmodels.coordinate import Coordinate, of_joint
from flexmodels.mechanics.plant import Equations
from flexmodels.scratch import scratch_folder

_FUNCTIONS = ("rates", "breakaway", "laws", "balance", "start", "tip")
RUNTIME = Path(str(resources.files("flexfmu") / "runtime"))


def model_sources(equations: Equations, derivatives: bool) -> dict[str, str]:
    """File name -> text of the generated files: model.h, model.c and, on demand, model_derivatives.c."""
    interface = plant_interface(equations)
    functions = [_renamed(getattr(equations, name)) for name in _FUNCTIONS]
    extra = _derivatives(equations) if derivatives else []
    files = {
        "model.c": _shared_tables(interface, _positive(equations))
        + _tables(equations)
        + _generated(functions, "model")
    }
    if derivatives:
        files["model_derivatives.c"] = '#include "model.h"\n' + _generated(extra, "derivatives")
    loop = equations.servo or equations.controller
    period = loop.period if loop else None
    plant = _plant_header(equations, [*functions, *extra], derivatives)
    kind = "SERVO" if equations.servo else "CONTROLLER"
    return {"model.h": _header(interface, period, plant, _token(interface, files), kind)} | files


def controller_sources(interface: Interface) -> dict[str, str]:
    """File name -> text of the generated files of a controller alone: model.h and model.c."""
    files = {"model.c": _shared_tables(interface, frozenset())}
    return {"model.h": _header(interface, interface.step, "", _token(interface, files))} | files


def _token(interface: Interface, files: dict[str, str]) -> str:
    return hashlib.sha256("".join([*files.values(), repr(interface)]).encode()).hexdigest()[:32]


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
    with scratch_folder() as folder:
        generator = ca.CodeGenerator(f"{prefix}.c", {"casadi_int": "int", "with_export": False, "cpp": False})
        for function in functions:
            generator.add(function)
        try:
            os.chdir(folder)  # CasADi writes only to the current directory
            generator.generate()
        finally:
            os.chdir(here)
        return (folder / f"{prefix}.c").read_text()


def _renamed(function: ca.Function) -> ca.Function:
    symbols = function.sx_in()
    return ca.Function(f"model_{function.name()}", symbols, function.call(symbols))


def _header(
    interface: Interface, period: float | None, plant: str, token: str, loop: str = "CONTROLLER"
) -> str:
    controller = f"#define MODEL_{loop}\n#define PERIOD {period!r}" if period else "/* no controller */"
    return f"""/* Sizes, tables and functions of {interface.identifier}. */
#ifndef MODEL_H
#define MODEL_H

#define MODEL_IDENTIFIER "{interface.identifier}"
#define MODEL_TOKEN "{token}"
#define N_JOINTS {interface.joints}
{controller}

/* By value reference: name, kind, lower bound, start. */
enum {{ KIND_INPUT = 'i', KIND_STATE = 's', KIND_CALCULATED = 'c', KIND_FIXED = 'f', KIND_TUNABLE = 't' }};
enum {{ BOUND_NONE = '-', BOUND_NOT_NEGATIVE = '0', BOUND_POSITIVE = '+' }};
extern const char *const model_names[];
extern const char model_kinds[];
extern const char model_bounds[];
extern const double model_starts[];
{plant}
#endif
"""


def _shared_tables(interface: Interface, positive: frozenset[str]) -> str:
    kinds = {("parameter", "fixed"): "f", ("parameter", "tunable"): "t", ("input", "continuous"): "i"}
    listed = interface.listed
    letters = [
        "s" if v.name in interface.states else kinds.get((v.causality, v.variability), "c") for v in listed
    ]
    bounds = ["+" if v.name in positive else "-" if v.minimum is None else "0" for v in listed]
    return "\n".join(
        [
            '#include "model.h"',
            _array("char *const", "model_names", [c_string(v.name) for v in listed]),
            f'const char model_kinds[] = "{"".join(letters)}";',
            f'const char model_bounds[] = "{"".join(bounds)}";',
            _array("double", "model_starts", [repr(float(v.start or 0.0)) for v in listed]),
            "",
        ]
    )


def _positive(equations: Equations) -> frozenset[str]:
    """Parameters that the equations divide by: stiffnesses, and motor inertias behind a flexible hinge."""
    hinges = [Coordinate.parse(name) for name in equations.coordinates[equations.joints :]]
    inertias = {of_joint(hinge.joint, "J_m") for hinge in hinges}
    resistances = {of_joint(k, "servo.R") for k in range(1, equations.joints + 1)}
    return frozenset({str(hinge.stiffness) for hinge in hinges} | inertias | {"solver.step"} | resistances)


def _plant_header(equations: Equations, functions: list[ca.Function], derivatives: bool) -> str:
    prototypes = "\n".join(
        f"int {f.name()}(const double **arg, double **res, int *iw, double *w, int mem);" for f in functions
    )
    return f"""
#define MODEL_PLANT
#define N_COORDINATES {len(equations.coordinates)}
#define N_MEMORIES {len(equations.memories)}
#define N_STATES (2 * N_COORDINATES + N_MEMORIES)
#define N_PARAMETERS {len(equations.parameters)}
{"#define MODEL_DERIVATIVES" if derivatives else "/* without derivatives */"}
#define MODEL_SZ_ARG {max(f.sz_arg() for f in functions)}
#define MODEL_SZ_RES {max(f.sz_res() for f in functions)}
#define MODEL_SZ_W {max(1, *(f.sz_w() for f in functions))}

extern const double model_nominals[N_STATES];
extern const unsigned char model_sticking[N_JOINTS];
extern const int model_stiffness[N_COORDINATES - N_JOINTS + 1]; /* parameter of each deformation */

{prototypes}
"""


def _tables(equations: Equations) -> str:
    names = list(equations.parameters)
    hinges = [Coordinate.parse(name) for name in equations.coordinates[equations.joints :]]
    stiffness = [names.index(str(hinge.stiffness)) for hinge in hinges]
    return "\n".join(
        [
            _array("double", "model_nominals", [repr(v) for v in nominals(equations)]),
            _array("unsigned char", "model_sticking", [str(int(s)) for s in equations.sticking]),
            _array("int", "model_stiffness", [*map(str, stiffness), "0"]),
            "",
        ]
    )


def _array(kind: str, name: str, values: list[str]) -> str:
    return f"const {kind} {name}[] = {{{', '.join(values)}}};"

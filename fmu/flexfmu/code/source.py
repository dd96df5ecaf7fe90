"""The model's own C: what differs from robot to robot. Everything else lies in runtime/."""

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path

from flexfmu.code.generated import Generated, inner, outer
from flexfmu.code.generated import derivatives as generated_derivatives
from flexfmu.dependencies import Dependencies
from flexfmu.interface import Interface, plant_interface
from flexfmu.names import c_string
from flexfmu.variables import nominals
from flexmodels.coordinate import Coordinate
from flexmodels.mechanics.plant import Equations

LICENSES = Path(str(resources.files("flexfmu") / "licenses"))
RUNTIME = Path(str(resources.files("flexfmu") / "runtime"))


def model_sources(
    equations: Equations, derivatives: bool, adjoint: bool, lanes: Sequence[str] = ()
) -> dict[str, str]:
    """File name -> text of the generated files; `adjoint`: with the products of the transposed Jacobian too.

    What changes with the parameters' values alone stands apart, in model_tables.c and model_token.h: the rest
    is then an object that has been compiled before.
    """
    interface = plant_interface(equations)
    inside, outside = inner(equations), outer(equations)
    products = generated_derivatives(equations) if derivatives else []
    files = {
        "model_rates.h": "\n".join(g.c for g in inside),
        "model_tables.c": _shared_tables(interface) + _tables(equations),
        "model.c": '#include "model.h"\n#include "scalar.h"\n#include "model_rates.h"\n'
        + "\n".join(g.c for g in outside),
    }
    for name, wanted in {"model_forward.c": derivatives, "model_adjoint.c": adjoint}.items():
        if wanted:
            body = "\n".join(g.c for g in products if (g.name == "adjoint") == (name == "model_adjoint.c"))
            files[name] = f'#include "model.h"\n#include "scalar.h"\n{body}'
    plant = _plant_header(equations, [*inside, *outside, *products], derivatives, lanes)
    period = equations.servo.period if equations.servo else None
    return {"model.h": _header(interface, plant, period), **_token_file(_token(interface, files))} | files


def controller_sources(interface: Interface) -> dict[str, str]:
    """File name -> text of the generated files of a controller alone."""
    files = {"model_tables.c": _shared_tables(interface)}
    return {"model.h": _header(interface, ""), **_token_file(_token(interface, files))} | files


def _token(interface: Interface, files: dict[str, str]) -> str:
    """Of the C and the interface; sets are sorted, whose order differs from process to process."""
    structure = [
        {name: sorted(knowns) for name, knowns in depends.items()}
        for depends in (interface.dependencies.running, interface.dependencies.initial)
    ]
    shown = repr(replace(interface, dependencies=Dependencies({}, {}))) + repr(structure)
    return hashlib.sha256("".join([*files.values(), shown]).encode()).hexdigest()[:32]


def token_of(sources: dict[str, str]) -> str:
    """The instantiation token that the sources carry."""
    return sources["model_token.h"].split('"')[1]


def _token_file(token: str) -> dict[str, str]:
    return {"model_token.h": f'#define MODEL_TOKEN "{token}"\n'}


def _header(interface: Interface, plant: str, period: float | None = None) -> str:
    loop = "/* no controller */"
    if interface.sampled:
        servo = f"#define MODEL_SERVO\n#define PERIOD {period!r}"
        loop = f"#define MODEL_SAMPLED\n{servo if period else '#define MODEL_CONTROLLER'}"
    return f"""/* Sizes, tables and functions of {interface.identifier}. */
#ifndef MODEL_H
#define MODEL_H

#define MODEL_IDENTIFIER "{interface.identifier}"
#define MODEL_PREFIX {interface.identifier}_
#ifdef {interface.identifier}_EXPORTS
#define MODEL_SHARED /* CMake compiles it for a shared library of this name, as FMPy does */
#endif
#include "symbols.h"
#define N_JOINTS {interface.joints}
{loop}

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


def _shared_tables(interface: Interface) -> str:
    kinds = {("parameter", "fixed"): "f", ("parameter", "tunable"): "t", ("input", "continuous"): "i"}
    kinds["input", "discrete"] = "i"
    listed = interface.listed
    letters = [
        "s" if v.name in interface.states else kinds.get((v.causality, v.variability), "c") for v in listed
    ]
    bounds = ["-" if v.minimum is None else "+" if v.minimum > 0 else "0" for v in listed]
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


def _plant_header(
    equations: Equations, functions: list[Generated], derivatives: bool, lanes: Sequence[str]
) -> str:
    vectors = "\n".join(f"#define MODEL_{name.upper()}" for name in lanes)
    prototypes = "\n".join(g.prototype for g in functions)
    return f"""
#define MODEL_PLANT
#define N_COORDINATES {len(equations.coordinates)}
#define N_MEMORIES {len(equations.memories)}
#define N_STATES (2 * N_COORDINATES + N_MEMORIES)
#define N_PARAMETERS {len(equations.parameters)}
{"#define MODEL_DRIVE" if equations.drives else "/* without drives */"}
#define N_SHOWN {equations.shown.numel_out(0)}
{"#define MODEL_DERIVATIVES" if derivatives else "/* without derivatives */"}
{vectors}

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
